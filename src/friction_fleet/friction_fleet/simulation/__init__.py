"""A generated fleet: unknown cars on the roads of a town whose friction is known."""
