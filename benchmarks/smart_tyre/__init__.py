"""Fz and Fx from the in-tyre accelerometer."""
