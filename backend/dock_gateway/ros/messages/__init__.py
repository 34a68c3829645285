"""ROS messages to JSON and back, compiled from the message definitions."""
