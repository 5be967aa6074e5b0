"""ROS 2 side of abs_supervisor: messages in, messages out, and the node."""
