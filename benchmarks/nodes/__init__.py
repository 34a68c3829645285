"""ROS programs that the benchmark starts in the product's environment."""
