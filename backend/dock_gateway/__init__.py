"""A web gateway to ROS 2 actions: REST, WebSockets and a dashboard."""

__version__ = "0.1.0"
