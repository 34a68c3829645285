"""The JSON shapes of stops."""

from datetime import datetime

from dock_gateway.http.schema import GatewayAddress, Problem, RosName, Schema


class StopFailure(Schema):
    """A part of a stop that failed: canceling goals of an action, or publishing zero velocity or the stop to a robot.

    `latch_not_published`: the robot was sent zero velocity, but the topic of its stop is of another type.
    """

    action_name: str | None
    robot: str | None
    code: str
    detail: str


class StopState(Schema):
    """Whether a stop is latched for one robot, since when and by whom.

    `robots` lists the robots at or below it that a stop holds. `persisted` is false if the gateway could not store its
    latest stop or release, so that a restart would lose it.
    """

    latched: bool
    stopped_at: datetime | None
    by: str | None
    robots: list[RosName]
    persisted: bool


class StopOfRobot(Schema):
    """Since when a stop holds a robot, and by whom."""

    robot: RosName
    stopped_at: datetime
    by: str | None


class LatchedStops(StopState):
    """Which of the robots that were asked about are stopped: one and those below it, several, or all.

    `latched` is true if a stop is latched for any of them, `for_all` only if for all of them, also for those that
    appear later. `stopped_at` and `by` are those of the first stop that is still latched, and `stops` has each robot
    of `robots` with its own.
    """

    for_all: bool
    stops: list[StopOfRobot]


class StopReport(Schema):
    """The result of a stop.

    `stopped` lists the robots to which zero velocity was published, `not_stopped` the other robots of this gateway: the
    stop was not for them, or it failed. Robots that the user's limits leave out are in neither. `unconfirmed` lists
    actions that were asked to cancel their goals and have not answered yet. `warning` says what in the request could
    not be understood, and whether all robots were stopped because of that, or that the stop is not stored yet.

    `others`: if this gateway has a share of the robots and the stop was for all of them, the other gateways. A stop
    that is latched reaches them over ROS, and each stops its own robots. Ask each with `GET /stop` whether it has.
    """

    stopped: list[str]
    not_stopped: list[str]
    canceling: list[str]
    failed: list[StopFailure]
    unconfirmed: list[str]
    stop: LatchedStops
    others: list[GatewayAddress]
    warning: "Problem | None"


class StopProblem(Problem):
    """Zero velocity could not be published to any robot. The other members say what was done nevertheless."""

    stopped: list[str] | None = None
    not_stopped: list[str] | None = None
    canceling: list[str] | None = None
    failed: list[StopFailure] | None = None
    unconfirmed: list[str] | None = None
    stop: LatchedStops | None = None
    others: list[GatewayAddress] | None = None
