"""Plain data and fan-out: goals, events, subscribers, errors. No ROS, no HTTP, no database."""
