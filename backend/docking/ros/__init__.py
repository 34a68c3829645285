"""The nodes' common use of rclpy: processes, parameters, action servers and clients."""
