"""What is measured."""

from dataclasses import dataclass

from dock_gateway.core.goal import Goal
from dock_gateway.core.hub import Hub
from dock_gateway.fleet.alerts import AlertBoard
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.ros.bridge import Bridge
from dock_gateway.settings import Settings
from dock_gateway.stop.stopper import Stopper
from dock_gateway.storage import History
from dock_gateway.webhooks.notifier import Notifier

# The prefix of the gateway's metrics.
NAMESPACE = "dock_gateway"
# The label `verb` of goals: what they do to a robot. `other` is any action that is neither docking nor undocking.
OTHER = "other"
VERBS = ("dock", "undock", OTHER)


@dataclass(frozen=True)
class Parts:
    """The parts of a gateway that its metrics are read from."""

    settings: Settings
    bridge: Bridge
    hub: Hub
    history: History
    actions: ActionRegistry
    robots: RobotRegistry
    stopper: Stopper
    alerts: AlertBoard
    notifier: Notifier


def verb_of(goal: Goal) -> str:
    """Return the label `verb` of a goal."""
    return goal.verb or OTHER
