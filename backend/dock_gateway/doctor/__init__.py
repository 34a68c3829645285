"""What a gateway needs from its environment, its machine and the ROS graph: checked before a start and on request."""
