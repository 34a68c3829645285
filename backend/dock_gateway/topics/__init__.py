"""The ROS graph, and the messages of any topic."""
