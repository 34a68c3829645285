"""What moves the robot at one stage: search, staging, approach, back out. Plain Python."""
