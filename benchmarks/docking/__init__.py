"""Docking from many random starts in the simulation: how often it works, how long it takes, how well it ends."""
