"""Record, replay, repair and offline processing of bags; importers for measured data."""
