"""Latched stops: which robots are held, on disk and on the ROS topic that other gateways hear."""
