"""The plant as a node: its messages, commands and pace."""
