"""Studies of the map against a town whose friction is known, and of the engine."""
