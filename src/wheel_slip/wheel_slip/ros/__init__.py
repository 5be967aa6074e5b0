"""ROS 2 side of wheel_slip: messages in, messages out, and the node."""
