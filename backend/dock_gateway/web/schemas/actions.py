"""The JSON shapes of actions and their servers."""

from dock_gateway.web.schemas.common import ActionServer, Schema


class ActionInfo(ActionServer):
    """An action on the graph; `hint` says what to install if its package is missing."""

    action_type: str
    installed: bool
    hint: str | None
    running_goals: int
    feedback_dropped: int


class ActionList(Schema):
    """The actions on the graph."""

    actions: list[ActionInfo]
