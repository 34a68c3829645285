"""The course of a goal: its stages, its velocities and its end."""

from dataclasses import dataclass, field, replace

from docking.core.observation import Velocity


@dataclass
class Course:
    """The course of a goal, in seconds since it was accepted.

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

    def until(self, at: float) -> "tuple[Course, float | None]":
        """Return a copy without the velocities and without what came after a moment; the moment, if something did."""
        if self.ended_at <= at:
            return replace(self, stages=list(self.stages), velocities=[]), None
        return Course([each for each in self.stages if each[0] <= at], ended_at=at), at
