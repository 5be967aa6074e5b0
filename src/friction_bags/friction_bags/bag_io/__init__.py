"""Bags of rosbag2: reading, writing and repair, and the messages in them. Nothing here depends on friction."""
