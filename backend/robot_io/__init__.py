"""Code for ROS that the gateway and the docking nodes share. It imports neither of them."""
