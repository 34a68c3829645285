"""The Fibonacci server and client of the ROS 2 action tutorials."""
