"""Curves from measured data."""
