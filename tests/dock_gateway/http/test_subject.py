"""What a request or a command is about: however it is spelled, rights judge and the audit log records the same."""

import re
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import dock_gateway
from dock_gateway.audit.subjects import Subjects
from dock_gateway.http.operation import Scope
from dock_gateway.http.subject import ON_GRAPH, read_subject
from dock_gateway.settings import Settings

SETTINGS = Settings(namespace="/robot1")
SUBJECTS = Subjects(SETTINGS, lambda _: None, list)
GOAL = "7d9c1c9e-0000-4000-8000-00000000000a"
NAMES = ("robot", "action", "goal_id", "topic", "node", "service", "alert_id", "approval_id")
texts = st.lists(st.sampled_from(["robot1", "robot2", "arm", "dock"]), max_size=3).map("/".join)
anything = st.one_of(
    st.none(), st.integers(), texts, texts.map("/{}".format), st.just("a b"), st.lists(texts, max_size=2)
)


@given(st.sampled_from([*ON_GRAPH]), texts)
def test_a_name_on_the_graph_is_the_same_with_its_slash_or_without(scope: Scope, name: str) -> None:
    both = [{ON_GRAPH[scope]: name}, {ON_GRAPH[scope]: f"/{name}"}]
    first, second = (read_subject(scope, each, SETTINGS) for each in both)
    assert first == second
    assert SUBJECTS.of_names(both[0], scope) == SUBJECTS.of_names(both[1], scope)


@given(st.sampled_from(Scope), st.dictionaries(st.sampled_from(NAMES), anything))
def test_every_spelling_is_read_and_recorded(scope: Scope, names: dict[str, Any]) -> None:
    """Refusing a name that is not valid is what rights do: it can be recorded nevertheless."""
    names = {"name": "robot1/dock", **names} if scope is Scope.ACTION else names
    subject, record = read_subject(scope, names, SETTINGS), SUBJECTS.of_names(names, scope)
    assert record["action_name"] == subject.action
    assert record["subject"] == (subject.name or None)
    if isinstance(subject.robot, str) and not subject.name:
        assert record["robot"] == f"/{subject.robot.strip('/')}"


@pytest.mark.parametrize(
    ("scope", "names", "robot"),
    [
        (Scope.ROBOT, {}, "/robot1"),
        (Scope.ROBOTS, {}, "/"),
        (Scope.ROBOTS, {"robot": "robot2"}, "/robot2"),
        (Scope.ANY, {"robot": ("/robot2", "/robot3")}, "/robot2,/robot3"),
        (Scope.ANY, {"robot": None}, "/"),
        (Scope.ANY, {}, None),
        (Scope.GOAL, {"goal_id": GOAL, "robot": "/robot9"}, None),
        (Scope.APPROVAL, {"approval_id": "a1"}, None),
        (Scope.NODE, {"node": "robot2/base", "robot": "/robot9"}, "/robot2"),
        (Scope.SERVICE, {}, "/"),
    ],
)
def test_a_record_names_the_robot_that_is_judged(scope: Scope, names: dict[str, Any], robot: str | None) -> None:
    assert SUBJECTS.of_names(names, scope)["robot"] == robot


NAMES_READ = re.compile(r"""(names|command)(\.get\(|\[)["'](robot|action|goal_id|topic|node|service)["'](?!] =)""")


def test_nothing_that_judges_or_records_reads_names_itself() -> None:
    package = Path(dock_gateway.__file__).parent
    files = [path for room in ("access", "audit") for path in (package / room).glob("*.py")]
    assert [path.name for path in files if NAMES_READ.search(path.read_text())] == []
