"""How fast dock-gateway is, beside a bare rclpy client and its peers, all in one run."""
