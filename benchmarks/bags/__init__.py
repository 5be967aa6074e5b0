"""Speed and memory of offline processing."""
