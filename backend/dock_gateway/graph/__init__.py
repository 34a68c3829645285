"""The ROS graph, and viewing the messages of any topic."""
