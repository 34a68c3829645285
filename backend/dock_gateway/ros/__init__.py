"""The ROS side: the only part of the gateway that imports rclpy."""
