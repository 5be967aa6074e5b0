"""ABS supervisory logic: the finite state machine of Figure 8.1."""
