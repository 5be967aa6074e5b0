"""The checks, one idea each. Those of units and signs come first: the others take what they found as mended."""
