"""The JSON shapes of recordings."""

from typing import Literal

from dock_gateway.http.schema import Schema


class GoalRecording(Schema):
    """The recording of a goal at this gateway: it is there, still being made, or there is none, and the reason.

    `picture`: whether it has a picture of a camera, for the thumbnail.
    """

    state: Literal["complete", "running", "none"]
    size_bytes: int | None
    picture: bool
    reason: str | None


class ReplayScan(Schema):
    """What the laser saw: points (x, y) in metres, as seen from the robot. `offset_s`: since the goal began."""

    offset_s: float
    points: list[list[float]]


class ReplayVelocity(Schema):
    """The commanded velocity: m/s and rad/s."""

    offset_s: float
    linear: float | None
    angular: float | None


class ReplayBattery(Schema):
    """What its battery said: V, and the charge (0 to 1)."""

    offset_s: float
    voltage: float | None
    percentage: float | None


class ReplayLine(Schema):
    """A line that a node logged, or a diagnosis that became worse or better; `node` is the name of either."""

    offset_s: float
    level: Literal["info", "warning", "error", "fatal"]
    node: str
    text: str


class GoalReplay(Schema):
    """What the replay of a goal shows of its recording, thinned: at most five of each in a second, and 400 of each.

    `log`: what nodes of the robot said meanwhile, at most 400 lines.
    """

    scans: list[ReplayScan]
    velocity: list[ReplayVelocity]
    battery: list[ReplayBattery]
    log: list[ReplayLine]


# What a goal has more.
GOAL_FIELDS = {"recording": GoalRecording}
