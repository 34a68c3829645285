"""Actions as JSON: those that the gateway has joined, and those that it cannot use."""

from dataclasses import dataclass
from typing import Any

from dock_gateway.core.goal import Verb
from dock_gateway.goals.liveness import ServerState


def action_document(
    state: ServerState,
    verb: Verb | None,
    hint: str | None,
    *,
    installed: bool = True,
    running_goals: int = 0,
    feedback_dropped: int = 0,
    unknown_goals_ignored: int = 0,
) -> dict[str, Any]:
    """Return an action as JSON, as in `ActionInfo`, which says what the values mean."""
    return {
        "action_name": state.action_name,
        "action_type": state.action_type,
        "verb": verb,
        "available": state.available,
        "answering": state.answering,
        "duplicate": state.duplicate,
        "installed": installed,
        "hint": hint,
        "running_goals": running_goals,
        "feedback_dropped": feedback_dropped,
        "unknown_goals_ignored": unknown_goals_ignored,
    }


@dataclass(frozen=True)
class Uninstalled:
    """An action on the graph that cannot be used, usually because its interface package is not installed here.

    Attributes:
        name: Absolute name.
        type: Its type on the graph.
        verb: Whether its name says that it docks or undocks a robot.
        hint: Why it cannot be used, and what to install.
    """

    name: str
    type: str
    verb: Verb | None
    hint: str

    def document(self) -> dict[str, Any]:
        """Return the action as JSON."""
        state = ServerState(self.name, self.type, available=True, answering=False)
        return action_document(state, self.verb, self.hint, installed=False)
