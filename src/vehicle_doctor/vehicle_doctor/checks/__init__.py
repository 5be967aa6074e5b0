"""Checks of a drive. Units and signs come first: the checks that follow work on corrected signals."""
