"""Bags of any car through a signal map."""
