"""Two checkouts compared over every bag."""
