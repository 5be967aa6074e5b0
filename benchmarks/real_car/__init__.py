"""Friction curves of cars that are not known exactly, on the independent plant corner_sim.car."""
