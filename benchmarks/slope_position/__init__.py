"""Slope sign of whole cars in ABS stops, on a plant that shares no code with the estimators."""
