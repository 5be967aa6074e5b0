"""Bags from tables and logs of any car."""
