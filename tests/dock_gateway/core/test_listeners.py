"""A mistake of one who listens harms no other, and not what is listened to."""

import ast
from pathlib import Path

import pytest

from dock_gateway.core.listeners import Listeners

BACKEND = Path(__file__).parents[3] / "backend"


def test_one_that_fails_keeps_nobody_from_the_rest(caplog: pytest.LogCaptureFixture) -> None:
    listeners = Listeners[[str]]("a robot is stopped")
    heard: list[str] = []

    def fail(_: str) -> None:
        raise ZeroDivisionError

    for listener in (heard.append, fail, heard.append):
        listeners.append(listener)
    listeners("/robot1")
    assert heard == ["/robot1", "/robot1"]
    assert "a listener failed: a robot is stopped" in caplog.text
    assert "ZeroDivisionError" in caplog.text


def test_nobody_is_called_in_another_way() -> None:
    """What extensions can add themselves to, `on_...`, are listeners, whose failures are contained."""
    lists = [
        f"{path.name}: {ast.unparse(node.target)}"
        for package in ("dock_gateway", "dock_hub")
        for path in (BACKEND / package).rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.AnnAssign) and ast.unparse(node.annotation).startswith("list[Callable")
        if isinstance(node.target, ast.Attribute) and node.target.attr.startswith("on_")
    ]
    assert lists == []
