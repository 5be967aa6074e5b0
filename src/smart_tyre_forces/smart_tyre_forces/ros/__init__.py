"""ROS 2 side of smart_tyre_forces: messages in, messages out, and the node."""
