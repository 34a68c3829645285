"""The actions of robots that are fakes."""

from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.robots.labels import Labels, RobotLabel
from dock_gateway.settings import Settings
from tests.support.history import HistoryInMemory


class FakeRobots:
    """The robots on the graph."""

    def __init__(self, *namespaces: str) -> None:
        self._namespaces = sorted(namespaces)

    def namespaces(self) -> list[str]:
        """Return their namespaces."""
        return self._namespaces


def make_robot_actions(settings: Settings | None = None, *robots: str) -> RobotActions:
    """Return the actions of robots without labels, none of which has had a goal."""
    history, names = HistoryInMemory(), FakeRobots(*robots)
    labels = Labels(history.documents("label", RobotLabel), names.namespaces)
    return RobotActions(settings or Settings(), names, labels, history)
