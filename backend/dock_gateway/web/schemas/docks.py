"""The JSON shapes of docks."""

from dock_gateway.web.schemas.common import Schema
from dock_gateway.web.schemas.scene import Pose


class Dock(Schema):
    """A dock of a docking server's database. What the server does not say is null."""

    dock_id: str
    type: str | None
    frame: str | None
    pose: Pose | None
    id: str | None


class DockList(Schema):
    """The docks of a docking server.

    Attributes:
        node: Full name of the server's node.
        dock_database: The file that its docks are from; null if it has none.
        default: The dock that a request without `dock_id` means; null if the server decides.
        docks: In the order of the server.
    """

    node: str
    dock_database: str | None
    default: str | None
    docks: list[Dock]
