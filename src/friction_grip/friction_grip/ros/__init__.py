"""ROS 2 side of friction_grip: messages in, messages out, and the node."""
