"""Soak test of the whole graph over DDS."""
