"""Estimates of all wheels in one message for each stamp."""
