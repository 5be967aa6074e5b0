"""Bags of rosbag2: reading, writing and repair, and the messages in them. Nothing here knows of friction."""
