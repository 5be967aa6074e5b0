"""Vertical and longitudinal tyre force from an in-tyre accelerometer and a wheel encoder."""
