"""The recorded experiments of bags/, simulated from fixed seeds."""
