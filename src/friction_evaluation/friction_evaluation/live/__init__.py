"""The graph over DDS."""
