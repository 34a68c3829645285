"""Manual control of simulated robots: reset, place, and faults."""
