"""The course of a goal: its stages, its velocities and its end."""

from dataclasses import dataclass, field

from docking.core.observation import Velocity


@dataclass
class Course:
    """What became of a goal, in seconds since it was accepted.

    Attributes:
        stages: Each stage, and when it began.
        velocities: Each commanded velocity, and when it was commanded.
        end: How the goal ended: `SUCCEEDED`, `CANCELED` or `ABORTED`; empty while it runs.
        error_code: Why it was aborted; empty otherwise.
        error_msg: The same as a sentence.
        ended_at: When it ended, or was last seen.
    """

    stages: list[tuple[float, str]] = field(default_factory=list)
    velocities: list[tuple[float, Velocity]] = field(default_factory=list)
    end: str = ""
    error_code: str = ""
    error_msg: str = ""
    ended_at: float = 0.0

    def enter(self, at: float, stage: str) -> None:
        """Note a stage, unless it goes on."""
        if not self.stages or self.stages[-1][1] != stage:
            self.stages.append((at, stage))
