"""A recorded drive as arrays, as a summary on the terminal, and as an interactive page."""
