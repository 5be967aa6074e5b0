"""Hostile messages to every processor and node."""
