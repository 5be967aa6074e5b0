"""ROS 2 side of friction_slope: messages in, messages out, and the node."""
