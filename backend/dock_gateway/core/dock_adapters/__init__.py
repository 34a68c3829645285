"""Adapters for the types of docking actions, one module for each family of types.

Plain data and pure functions: they know no ROS, no clock and no socket. `catalog` lists the types in their order of
preference, and knows by which names they are found on the ROS graph.
"""
