"""Parameters that tell by the joints whether the wheels press against the dock."""

from dataclasses import dataclass

from docking.core.parameter import names, number, switch


@dataclass(frozen=True, slots=True)
class StallSettings:
    """Stall detection; the names are nav2's."""

    use_stall_detection: bool = switch(
        False,
        "Whether joints that stall within docking_threshold of the docked pose tell that the robot is on the dock: "
        "sooner than odometry, and where odometry does not tell.",
    )
    stall_joint_names: tuple[str, ...] = names(
        "[left_wheel_joint, …]", "Joints of joint_states whose mean velocity and effort count."
    )
    stall_velocity_threshold: float = number(
        1.0, 0.0, 1000.0, "rad/s", "Mean velocity of the joints below which they stall, if their effort is high."
    )
    stall_effort_threshold: float = number(
        1.0, 0.0, 10000.0, "N·m", "Mean effort of the joints above which they stall."
    )

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints whose effort counts; none without stall detection."""
        return self.stall_joint_names if self.use_stall_detection else ()
