"""Record, replay, repair and offline processing of bags; importers for tables and logs of any car."""
