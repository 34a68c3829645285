"""Latched stops: which robots are held, on disk and on the ROS topic shared with other gateways."""
