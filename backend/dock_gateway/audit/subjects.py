"""Names the subject in an audit entry: the robot, the action and the goal of a request or a command."""

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any

from starlette.requests import HTTPConnection
from starlette.types import Scope as ConnectionScope

from dock_gateway.core.audit import MAX_ROBOTS
from dock_gateway.core.dock_adapters.catalog import DockingCatalog
from dock_gateway.core.filters import is_under, parent_of
from dock_gateway.core.namespace import ALL_ROBOTS, normalize_namespace
from dock_gateway.http.operation import READS, Scope, find_operation
from dock_gateway.http.requests import GOAL_ID, read_goal_id
from dock_gateway.http.subject import read_subject
from dock_gateway.settings import Settings

# Parameters of paths that a subject has, or its columns.
KNOWN = frozenset({"goal_id", "name", "service", "node", "topic"})
# What is about one robot: the configured one, if no name says more.
OF_A_ROBOT = frozenset({Scope.ROBOT, Scope.ROBOTS, Scope.DOCK, Scope.UNDOCK, Scope.NEW_GOAL, Scope.GOAL})
# What only the request says.
FIELDS = ("robot", "action_name", "goal_id", "subject")

Fields = dict[str, str | None]


class Subjects:
    """Says what a request is about.

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

    def of_request(self, scope: ConnectionScope) -> Fields:
        """Return what the path and the query say."""
        connection = HTTPConnection(scope)
        path, query = connection.path_params, connection.query_params
        if scope["method"] in READS:
            return {"goal_id": path.get("goal_id"), "subject": str(query) or None}
        operation = find_operation(scope["route"])
        names = dict(path)
        if "robot" in scope["route"].query_names:
            names["robot"] = tuple(query.getlist("robot")) or None
        fields = self.of_names(names, Scope.ANY if operation is None else operation.scope)
        others = ", ".join(str(value) for name, value in path.items() if name not in KNOWN)
        return fields | {"subject": fields["subject"] or others or None}

    def of_names(self, names: Mapping[str, Any], scope: Scope) -> Fields:
        """Return what names say: those of a request, or the fields of a command."""
        subject = read_subject(scope, names, self._settings)
        goal_id = subject.identity if scope is Scope.GOAL and isinstance(subject.identity, str) else None
        robots = subject.robot if isinstance(subject.robot, tuple) else (subject.robot,)
        if subject.name:
            robots = (parent_of(subject.name),)
        elif subject.action is None and goal_id is None and scope in OF_A_ROBOT:
            robots = tuple(each if isinstance(each, str) else self._settings.namespace for each in robots)
        return {
            "robot": robots_text(each for each in robots if isinstance(each, str)),
            "action_name": subject.action,
            "goal_id": goal_id,
            "subject": subject.name or None,
        }

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
