"""Controllers: what moves the robot towards its dock."""
