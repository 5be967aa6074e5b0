"""Examines the signals of a drive on whole arrays, without middleware, and learns the vehicle file from it."""
