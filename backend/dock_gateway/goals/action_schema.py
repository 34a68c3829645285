"""The JSON shapes of actions and their servers."""

from dock_gateway.core.goal import Verb
from dock_gateway.http.schema import RosName, Schema


class ActionServer(Schema):
    """Whether an action server is on the graph and answers. `duplicate` is true if there is more than one."""

    action_name: RosName
    action_type: str
    available: bool
    answering: bool
    duplicate: bool


class ActionInfo(ActionServer):
    """An action on the graph.

    `hint` says what to install if its package is missing, or which node names too many unknown goals.
    """

    verb: Verb | None
    installed: bool
    hint: str | None
    running_goals: int
    feedback_dropped: int
    unknown_goals_ignored: int


class ActionList(Schema):
    """The actions on the graph."""

    actions: list[ActionInfo]
