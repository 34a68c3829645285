"""The quality of service of a recorded topic, as rosbag2 writes it into a channel's metadata.

The policies are numbers, as up to version 8 of rosbag2's metadata: Humble reads nothing else, later ones read both.
"""

from functools import cache

# RELIABLE or BEST_EFFORT, TRANSIENT_LOCAL or VOLATILE, as rmw numbers them.
RELIABILITY, DURABILITY = {True: 1, False: 2}, {True: 1, False: 2}
DEPTH = 10
INFINITE = "{sec: 9223372036, nsec: 854775807}"


@cache
def offered_qos(*, reliable: bool, kept: int) -> str:
    """Return what publishers offer, as YAML.

    Args:
        reliable: Whether they send again what was lost.
        kept: Number of messages that they keep for later subscribers (transient local); 0: none (volatile).
    """
    return f"""- history: 1
  depth: {kept or DEPTH}
  reliability: {RELIABILITY[reliable]}
  durability: {DURABILITY[kept > 0]}
  deadline: {INFINITE}
  lifespan: {INFINITE}
  liveliness: 1
  liveliness_lease_duration: {INFINITE}
  avoid_ros_namespace_conventions: false
"""
