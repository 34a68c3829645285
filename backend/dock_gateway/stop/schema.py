"""The JSON shapes of stops."""

from datetime import datetime

from dock_gateway.http.schema import GatewayAddress, Problem, Schema


class StopFailure(Schema):
    """A part of a stop that failed: canceling the goals of an action, or publishing zero velocity to a robot."""

    action_name: str | None
    robot: str | None
    code: str
    detail: str


class StopState(Schema):
    """Whether a stop is latched for a robot, since when and by whom.

    `robots` lists the robots at or below it that a stop holds. `persisted` is false if the gateway could not store its
    latest stop or release, so that a restart would lose it.
    """

    latched: bool
    since: datetime | None
    by: str | None
    robots: list[str]
    persisted: bool


class StopReport(Schema):
    """The result of a stop.

    `unconfirmed` lists actions that were asked to cancel their goals and have not answered yet. `warning` says what in
    the request could not be read and was ignored, or that the stop is not stored yet.

    `others`: if this gateway has a share of the robots and the stop was for all of them, the other gateways. A stop
    that is latched reaches them over ROS, and each stops its own robots. Ask each with `GET /stop` whether it has.
    """

    canceling: list[str]
    failed: list[StopFailure]
    unconfirmed: list[str]
    stop: StopState
    others: list[GatewayAddress]
    warning: "Problem | None"


class StopProblem(Problem):
    """Zero velocity could not be published to any robot. The other members say what was done nevertheless."""

    canceling: list[str] | None = None
    failed: list[StopFailure] | None = None
    unconfirmed: list[str] | None = None
    stop: StopState | None = None
    others: list[GatewayAddress] | None = None
