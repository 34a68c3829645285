"""Tells by their joints whether the wheels stall."""

from docking.core.observation import Observation
from docking.parameters import StallSettings

FRESH = 0.5
"""How old the reading of a joint may be, in s."""


def stalls(observation: Observation, settings: StallSettings) -> bool:
    """Whether the joints hardly turn although they are driven hard; never while one of them is silent.

    Args:
        observation: With the joints.
        settings: Which ones count, and from when on they stall.
    """
    read = [joint for name in settings.joints if (joint := observation.joints.get(name)) is not None]
    if not read or len(read) < len(settings.joints) or any(observation.now - one.stamp > FRESH for one in read):
        return False
    velocity = sum(abs(joint.velocity) for joint in read) / len(read)
    effort = sum(abs(joint.effort) for joint in read) / len(read)
    return velocity < settings.stall_velocity_threshold and effort > settings.stall_effort_threshold
