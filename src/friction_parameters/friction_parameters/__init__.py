"""Parameters as typed dataclasses: one definition for code, files, nodes and tables. No ROS."""
