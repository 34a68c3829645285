"""The actions of robots that are fakes."""

from dock_gateway.core.errors import NotFound
from dock_gateway.goals.known_robots import KnownRobots
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.robots.labels import Labels, RobotLabel
from dock_gateway.settings import Settings
from dock_gateway.storage import History
from tests.support.history import HistoryInMemory


class FakeRobots:
    """The robots on the graph."""

    def __init__(self, *namespaces: str) -> None:
        self._namespaces = sorted(namespaces)

    default_namespace = "/"
    own_robot = True

    def namespaces(self) -> list[str]:
        """Return their namespaces."""
        return self._namespaces

    def find(self, namespace: str | None = None) -> str:
        """Return the namespace of a robot; default: `/`."""
        name = self.default_namespace if namespace is None else namespace
        if name not in self._namespaces:
            raise NotFound(f"there is no robot {name}", code="robot_not_found")
        return name


def make_robot_actions(settings: Settings | None = None, *robots: str) -> RobotActions:
    """Return the actions of robots without labels, none of which has had a goal."""
    history, names = HistoryInMemory(), FakeRobots(*robots)
    labels = Labels(history.documents("label", RobotLabel), names.namespaces)
    return RobotActions(settings or Settings(), names, labels, history)


def make_known_robots(history: History, *robots: str, settings: Settings | None = None) -> KnownRobots:
    """Return what is known of robots: those on the graph, and those that the history has."""
    chosen, names = settings or Settings(), FakeRobots(*robots)
    labels = Labels(history.documents("label", RobotLabel), names.namespaces)
    return KnownRobots(chosen, names, labels, RobotActions(chosen, names, labels, history), history)
