"""Hostile messages into every processor: what comes out, how long it takes, and what is left of it afterwards."""
