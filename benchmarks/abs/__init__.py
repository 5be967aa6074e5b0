"""Stops of one corner with the supervisor in the loop."""
