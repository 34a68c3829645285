"""ROS 2 nodes of the docking tutorial: action server, action client, battery monitor, Fibonacci."""
