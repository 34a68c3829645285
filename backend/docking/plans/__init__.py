"""How to dock with one kind of sensor: which behavior at which stage."""
