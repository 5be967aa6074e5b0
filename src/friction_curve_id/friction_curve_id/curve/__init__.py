"""A fitted curve: its peak, its standard deviations, and whether it may be used."""
