"""The estimators over a bag, without middleware."""
