"""ROS 2 side of friction_state: messages in, messages out, and the node."""
