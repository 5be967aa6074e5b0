"""ROS 2 side of friction_curve_id: messages in, messages out, and the node."""
