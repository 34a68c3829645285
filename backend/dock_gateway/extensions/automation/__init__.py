"""Automatic docking: rules that send robots to their docks."""
