"""The JSON shapes of gateways."""

from datetime import datetime

from dock_gateway.http.schema import GatewayAddress, Schema


class RunningGateway(GatewayAddress):
    """A gateway that runs.

    `robots` are patterns of the robots that it serves, none if it serves every robot; `serves` are those that it has
    found. `claimed` is false if another gateway had them first: both serve them then. `seen_at` is when it last stored
    this, by its own clock. `this` is the one that answers.
    """

    id: str
    this: bool
    serves: list[str]
    version: str
    started_at: datetime
    seen_at: datetime
    claimed: bool


class GatewayList(Schema):
    """The gateways on one database.

    `shared` is false if the database can have one gateway only. `conflict` says which other gateway serves the same
    robots, if one does.
    """

    gateways: list[RunningGateway]
    shared: bool
    conflict: str | None
