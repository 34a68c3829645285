"""What several doors have is declared once: a door translates, and carries out an operation."""

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

import dock_gateway
from dock_gateway.extension_list import OURS

PACKAGE = Path(dock_gateway.__file__).parent
DOORS = ("doors", "streams", *(f"extensions/{name}" for name in ("agents", "foxglove", "rosbridge") if name in OURS))
# Each of these requirements is that of one operation, whatever doors it has.
DECLARED = {
    "Role.AGENT, Scope.NEW_GOAL": ["operations/goals.py send_goal"],
    "Role.AGENT, Scope.GOAL": ["operations/goals.py cancel_goal"],
    "Role.VIEWER, Scope.ANY, reads_body": ["stop/order.py stops_robots"],
    "Role.SUPERVISOR, Scope.ROBOTS": ["stop/order.py releases_stop"],
    "Role.OPERATOR, Scope.SERVICE": ["operations/services.py call_service"],
    "Role.OPERATOR, Scope.PUBLISHING": ["operations/topics.py advertise", "operations/topics.py publish"],
    "Role.SUPERVISOR, Scope.NODE": ["operations/parameters.py set_parameters"],
    "Role.VIEWER, Scope.LOOKED_AT": [
        "doors/rest/service_routes.py get_service",
        "operations/parameters.py get_parameters",
    ],
    "Role.VIEWER, Scope.TOPIC": [
        "doors/rest/publish_routes.py get_topic_message",
        "graph/routes.py get_topic",
        "operations/topics.py subscribe",
    ],
    "Role.OPERATOR, Scope.ALERT": ["operations/fleet.py acknowledge_alert"],
    "Role.SUPERVISOR, Scope.ROBOT": [
        "operations/battery.py publish_battery",
        "operations/battery.py start_publishing",
        "operations/battery.py stop_publishing",
        "robots/calibration_routes.py calibrate_dock",
    ],
}


@cache
def declarations() -> list[tuple[str, str]]:
    """Each declaration of an operation in the code: what it needs; its file and name."""
    return list(_declarations())


def _declarations() -> Iterator[tuple[str, str]]:
    for path in sorted(PACKAGE.rglob("*.py")):
        file = path.relative_to(PACKAGE).as_posix()
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                calls: list[ast.expr] = node.decorator_list
                name = node.name
            elif isinstance(node, ast.Assign):
                calls, name = [node.value], ast.unparse(node.targets[0])
            else:
                continue
            for call in calls:
                if isinstance(call, ast.Call) and ast.unparse(call.func) == "operation":
                    marks = [each.arg for each in call.keywords if each.arg == "reads_body"]
                    needs = ", ".join([*(ast.unparse(each) for each in call.args[:2]), *filter(None, marks)])
                    yield needs.replace("needs.", "").replace("Subject.", "Scope."), f"{file} {name}"


@pytest.mark.parametrize("needs", DECLARED)
def test_an_operation_is_declared_once(needs: str) -> None:
    """Those of the gateway itself: an extension has its own in `operations.txt`, and can be taken out."""
    found = [where for needed, where in declarations() if needed == needs]
    assert sorted(where for where in found if not where.startswith("extensions/")) == DECLARED[needs]


@pytest.mark.parametrize("name", ["list_robots", "list_actions", "list_alerts"])
def test_a_list_is_declared_once(name: str) -> None:
    found = [where for _, where in declarations() if where.endswith(f" {name}")]
    assert found == [f"operations/fleet.py {name}"]


def test_a_door_declares_only_what_reads() -> None:
    acts = [where for needs, where in declarations() if where.startswith(DOORS) and "Role.VIEWER" not in needs]
    assert acts == ["extensions/agents/tools.py answer_approval"] * ("agents" in OURS)
