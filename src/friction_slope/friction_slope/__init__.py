"""Sign of the slope of the friction curve, equations (8.3) to (8.5)."""
