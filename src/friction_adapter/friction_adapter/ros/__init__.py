"""ROS 2 side of friction_adapter: messages in, messages out, and the node."""
