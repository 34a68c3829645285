"""Time limits of goals and of their stages."""

from dataclasses import dataclass

from docking.core.parameter import number

SPEED = 0.26
"""In m/s: slower robots have in proportion longer for ways whose length is not known before."""
MARGIN, START = 1.2, 2.0
"""How long a known way may take at least: a factor, and s."""


def at_least(limit: float, way: float) -> float:
    """Return a time limit that is no shorter than a way needs.

    Args:
        limit: As it is set, in s.
        way: Seconds that the way takes at the speed that is set.
    """
    return max(limit, START + MARGIN * way)


@dataclass(frozen=True)
class Timeouts:
    """Time limits of every goal."""

    battery_stale_after: float = number(
        2.0,
        0.1,
        3600.0,
        "s",
        "Time without a battery message after which the wheels stop; the goal continues with the next message.",
    )
    battery_lost_after: float = number(
        60.0,
        0.1,
        86400.0,
        "s",
        "Time without a battery message, counted from the goal's acceptance, after which it is aborted. "
        "Not below battery_stale_after.",
    )
    goal_timeout: float = number(
        0.0,
        0.0,
        86400.0,
        "s",
        "Maximum duration of a goal, after which it is aborted; 0: as long as its stages and waits may take, and with "
        "rotate no limit.",
    )
    odometry_timeout: float = number(
        5.0,
        0.1,
        60.0,
        "s",
        "Time without odometry after which the goal is aborted; does not apply to rotate. After 0.3 s "
        "without odometry the robot stands still; the goal continues with the next message.",
    )
    blocked_after: float = number(
        2.0,
        0.5,
        60.0,
        "s",
        "Time over which commanded and measured motion are compared; if they differ too much, the robot is blocked.",
    )


@dataclass(frozen=True)
class DockTimeouts(Timeouts):
    """Time limits and retries of a docking goal."""

    initial_perception_timeout: float = number(20.0, 0.1, 3600.0, "s", "Time limit for finding the dock.")
    staging_timeout: float = number(
        60.0,
        0.1,
        3600.0,
        "s",
        "Time limit for driving to the staging pose; with v_linear_max below 0.26 m/s in proportion longer.",
    )
    dock_approach_timeout: float = number(
        30.0, 0.1, 3600.0, "s", "Time limit for driving from the staging pose to the dock."
    )
    wait_charge_timeout: float = number(
        5.0, 0.1, 3600.0, "s", "Time limit for the battery to start charging on the dock."
    )
    charge_stable_for: float = number(
        1.0,
        0.0,
        60.0,
        "s",
        "Time for which the battery must charge without a break until the goal succeeds, with at least 3 messages that "
        "say so, 5 where they are rare; meanwhile the robot goes on to the docked pose. With rotate, the first battery "
        "message counts, as in the tutorial.",
    )
    retry_timeout: float = number(30.0, 0.1, 3600.0, "s", "Time limit for backing off.")
    max_retries: int = number(3, 0, 100, "", "Maximum number of retries; the robot backs off before each of them.")


@dataclass(frozen=True)
class UndockTimeouts(Timeouts):
    """Time limits of an undocking goal."""

    undocking_timeout: float = number(
        20.0, 0.1, 3600.0, "s", "Time limit for backing out until the battery no longer charges."
    )
