"""Bags from measured data in CSV files."""
