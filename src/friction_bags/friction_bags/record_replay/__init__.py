"""Recording of topics to a bag, and replay of a bag onto its topics."""
