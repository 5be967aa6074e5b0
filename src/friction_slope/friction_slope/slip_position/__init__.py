"""Slope sign by the position of the slip on the friction curve: a bank of hypotheses about the curve of each wheel."""
