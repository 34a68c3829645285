"""One robot, which is a namespace: its battery, its velocity, its simulator."""
