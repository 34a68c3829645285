"""Parameters of the way onto the dock."""

from dataclasses import dataclass

from docking.core.parameter import group, number


@dataclass(frozen=True, slots=True)
class Gains:
    """Constants of the smooth control law, with nav2's names."""

    k_phi: float = number(
        3.0,
        0.1,
        20.0,
        "",
        "How hard the robot steers towards the line that leads straight onto the dock, as a ratio of rates.",
    )
    k_delta: float = number(
        2.0, 0.1, 20.0, "", "Gain of the heading error: how hard the robot turns to the heading that k_phi asks for."
    )
    beta: float = number(
        0.4,
        0.0,
        10.0,
        "",
        "How much it slows down in curves: v = v_linear_max / (1 + beta * abs(curvature) ** lambda).",
    )
    lambda_: float = number(2.0, 0.1, 10.0, "", "How sharply it slows down in curves, see beta.")


def threshold_field() -> float:
    """The field for how far from the docked pose a docked robot may stand."""
    return number(
        0.05,
        0.005,
        0.5,
        "m",
        "Distance from the docked pose within which a robot whose wheels have stopped is taken to be docked.",
    )


def push_field() -> float:
    """The field for how far the robot pushes on after it has touched the dock."""
    return number(
        0.0,
        0.0,
        0.2,
        "m",
        "Distance that the robot pushes on at v_linear_min after it has come to the docked pose or has touched, for "
        "contacts on springs or behind a lip, also while its wheels stand; for 3 s longer than that takes, at most.",
    )


@dataclass(frozen=True, slots=True)
class ApproachSettings:
    """Parameters of the way from the staging pose onto the dock."""

    gains: Gains = group(Gains)
    slowdown_radius: float = number(
        0.1,
        0.0,
        1.0,
        "m",
        "The last part of the approach, which is driven at v_linear_min: the first contact may come earlier than the "
        "docked pose says, as with a bumper that is longer than the drawing.",
    )
    docking_threshold: float = threshold_field()
    docking_overshoot: float = number(
        0.045,
        0.0,
        0.2,
        "m",
        "Distance beyond the docked pose that is driven without a contact, before the robot is taken to be docked: the "
        "camera may be farther ahead than tf says.",
    )
    final_push: float = push_field()
    docking_lateral_tolerance: float = number(
        0.02,
        0.002,
        0.2,
        "m",
        "Maximum lateral error on the last 6 cm; with more, the robot backs off and retries. Before that, it stands "
        "still and looks until it knows the docked pose to 0.3 of this and of docking_heading_tolerance.",
    )
    docking_heading_tolerance: float = number(
        0.0873, 0.01, 0.8, "rad", "Maximum heading error there; with more, the robot backs off and retries."
    )
    look_timeout: float = number(
        10.0, 0.0, 600.0, "s", "Maximum time for that; then the robot drives on with what it knows."
    )
    blind_distance: float = number(
        0.15,
        0.0,
        1.0,
        "m",
        "Distance from the docked pose within which the robot drives on without seeing the dock.",
    )
