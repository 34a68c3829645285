"""Plans to dock, each with one kind of sensor: which behavior at which stage."""
