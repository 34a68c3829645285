"""What the nodes share of rclpy: processes, parameters, action servers and clients."""
