"""What the gateway and the docking nodes both need of ROS. It imports neither of them."""
