"""Methods of section 8.3: friction samples, and the curves that are fitted to them."""
