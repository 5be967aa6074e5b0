"""Slope sign of one corner, on simulated manoeuvres."""
