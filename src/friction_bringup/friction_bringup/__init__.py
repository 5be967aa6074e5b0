"""Starts the friction graph: launch files, parameter files, the demo and its live view, plots and summary."""
