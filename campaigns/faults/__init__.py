"""Faults in closed loop."""
