"""The subject of an audit entry: the robot, the action and the goal of a request or a command."""

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any

from starlette.requests import HTTPConnection
from starlette.types import Scope

from dock_gateway.core.audit import MAX_ROBOTS
from dock_gateway.core.dock_adapters.catalog import DockingCatalog
from dock_gateway.core.filters import is_under, parent_of
from dock_gateway.core.namespace import ALL_ROBOTS, normalize_namespace
from dock_gateway.http.operation import READS
from dock_gateway.http.operation import Scope as Subject
from dock_gateway.http.requests import GOAL_ID, read_goal_id
from dock_gateway.settings import Settings

# Parameters of paths that have a column of their own: `name` is that of an action.
COLUMNS = frozenset({"goal_id", "name"})
# Those that are names on the ROS graph, without their leading slash.
GRAPH_NAMES = frozenset({"service", "node", "topic"})
ON_GRAPH = frozenset({Subject.SERVICE, Subject.NODE, Subject.PUBLISHING})
# What only the request says.
FIELDS = ("robot", "action_name", "goal_id", "subject")

Fields = dict[str, str | None]


class Subjects:
    """Finds what a request is about.

    Args:
        settings: Resolve names.
        action_of: Returns the name of the action of a running goal, or None.
        robots: Returns the namespaces of the robots on the graph.
    """

    def __init__(
        self,
        settings: Settings,
        action_of: Callable[[str], str | None],
        robots: Callable[[], Collection[str]],
    ) -> None:
        self._settings = settings
        self._catalog = DockingCatalog(settings)
        self._action_of = action_of
        self._robots = robots

    def of_request(self, scope: Scope) -> Fields:
        """Return what the path and the query say."""
        connection = HTTPConnection(scope)
        path, query = connection.path_params, connection.query_params
        if scope["method"] in READS:
            return {"goal_id": path.get("goal_id"), "subject": str(query) or None}
        others = [
            f"/{value}" if name in GRAPH_NAMES else str(value) for name, value in path.items() if name not in COLUMNS
        ]
        robots = [parent_of(f"/{value}") for name, value in path.items() if name in GRAPH_NAMES]
        if any(field.name == "robot" for field in scope["route"].dependant.query_params):
            robots = query.getlist("robot") or [self._settings.namespace]
        return {
            "robot": robots_text(robots),
            "action_name": f"/{path['name']}" if "name" in path else None,
            "goal_id": path.get("goal_id"),
            "subject": ", ".join(others) or None,
        }

    def of_command(self, command: Mapping[str, Any], scope: Subject) -> Fields:
        """Return what the fields of a command say."""
        if scope in ON_GRAPH:
            name = next(str(command[each]) for each in GRAPH_NAMES if each in command)
            return {"robot": robots_text([parent_of(name)]), "subject": name}
        names = ("robot", "action", "goal_id")
        robot, action, goal_id = (each if isinstance(each := command.get(name), str) else None for name in names)
        if isinstance(robots := command.get("robot"), tuple):  # as a stop has them
            return {"robot": robots_text(robots), "action_name": None, "goal_id": None}
        if action is not None:
            action = self._settings.resolve(action, robot)
        elif goal_id is None:
            robot = self._settings.namespace if robot is None else robot
        return {"robot": robots_text([] if robot is None else [robot]), "action_name": action, "goal_id": goal_id}

    def completed(self, known: Mapping[str, str | None]) -> Fields:
        """Return all fields, with what follows from them: the action of a running goal, the robot of an action."""
        robot, action_name, goal_id, subject = (known.get(name) for name in FIELDS)
        if goal_id is not None and GOAL_ID.fullmatch(goal_id):
            goal_id = read_goal_id(goal_id)
            action_name = action_name or self._action_of(goal_id)
        if action_name is not None:  # a command may name another robot in addition to an absolute name
            robot = parent_of(self._catalog.place_of(action_name))
        if robot is not None and len(robot) > MAX_ROBOTS:
            # There is room for every robot, but not for any number of names that are none.
            present = set(self._robots())
            robot = ",".join(sorted(robot.split(","), key=lambda name: name not in present))
        return dict(zip(FIELDS, (robot, action_name, goal_id, subject), strict=True))

    def stopped(self, robots: str | None) -> str:
        """Return the robots that a stop was for: all if it names none that is known."""
        names, known = (robots or ALL_ROBOTS).split(","), self._robots()
        is_known = not known or any(is_under(each, name) for each in known for name in names)
        return ",".join(names) if is_known else ALL_ROBOTS


def robots_text(robots: Iterable[str]) -> str | None:
    """Return robots as an entry names them, each once. A name that is not valid must not look like several."""
    names = (normalize_namespace(robot).replace(",", "?") for robot in robots)
    return ",".join(dict.fromkeys(names)) or None
