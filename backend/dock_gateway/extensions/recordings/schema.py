"""The JSON shapes of recordings."""

from dock_gateway.http.schema import Schema


class GoalRecording(Schema):
    """Whether a goal has a recording at this gateway: its size in bytes, or `why_none`, or it is still `running`.

    `picture`: whether it has a picture of a camera, for the thumbnail.
    """

    size: int | None
    why_none: str | None
    running: bool
    picture: bool


class ReplayScan(Schema):
    """What the laser saw: points (x, y) in metres, as seen from the robot. `at`: seconds since the goal began."""

    at: float
    points: list[list[float]]


class ReplayVelocity(Schema):
    """The commanded velocity: m/s and rad/s."""

    at: float
    linear: float | None
    angular: float | None


class ReplayBattery(Schema):
    """What its battery said: V, and the charge (0 to 1)."""

    at: float
    voltage: float | None
    percentage: float | None


class GoalReplay(Schema):
    """What the replay of a goal shows of its recording, thinned: at most five of each in a second, and 400 of each."""

    scans: list[ReplayScan]
    velocity: list[ReplayVelocity]
    battery: list[ReplayBattery]


class PicturedGoals(Schema):
    """Those of the goals whose recording has a picture of a camera, for the thumbnail."""

    goal_ids: list[str]
