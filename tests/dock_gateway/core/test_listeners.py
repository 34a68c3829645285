"""A mistake of one who listens harms no other, and what an extension adds is gone when it is."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from dock_gateway.core.listeners import Hooks, Listeners

ROOT = Path(__file__).parents[3]
BACKEND = ROOT / "backend"
EXTENSIONS = BACKEND / "dock_gateway/extensions"
# Lists that are public, and that nothing of an extension is added to.
DATA = {
    "extension.py: metrics",
    "order.py: wrong",
    "listener.py: sockets",
    "velocity.py: listeners",
    "velocity.py: subscriptions",
    "bridge.py: branches",
    "graph_watch.py: findings",
    "bounds.py: Errors",
}


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


def test_what_is_added_for_a_block_is_gone_after_it() -> None:
    hooks = Hooks[str]()
    hooks.append("core")
    with hooks.adding("one"), hooks.adding("two"):
        assert list(hooks) == ["core", "one", "two"]
    with pytest.raises(OSError, match="half-way"), hooks.adding("one"):
        raise OSError("half-way")
    assert list(hooks) == ["core"]


def test_one_that_is_removed_while_they_are_called_keeps_no_other_from_being_called() -> None:
    listeners = Listeners[[]]("it is over")
    heard: list[str] = []
    first = listeners.adding(lambda: first.__exit__(None, None, None))
    with listeners.adding(lambda: heard.append("second")):
        first.__enter__()
        with listeners.adding(lambda: heard.append("third")):
            listeners()
    assert heard == ["second", "third"]
    assert not listeners


def trees(folder: Path) -> Iterator[tuple[Path, ast.AST]]:
    for path in folder.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            yield path, node


def test_what_others_add_to_are_hooks() -> None:
    """A list would have no `adding`, and would let the failure of one reach the others."""
    lists = set()
    for package in ("dock_gateway", "dock_hub"):
        for path, node in trees(BACKEND / package):
            if path.is_relative_to(EXTENSIONS):
                continue
            if isinstance(node, ast.ClassDef) and any(ast.unparse(base).startswith("list") for base in node.bases):
                lists.add(f"{path.name}: {node.name}")
            if not isinstance(node, ast.AnnAssign) or not isinstance(node.target, ast.Attribute):
                continue
            if ast.unparse(node.annotation).startswith("list[") and not node.target.attr.startswith("_"):
                lists.add(f"{path.name}: {node.target.attr}")
    assert lists == DATA


def hook_names() -> set[str]:
    """Return the names of all attributes that are hooks."""
    return {
        target.attr
        for package in ("dock_gateway", "dock_hub")
        for _, node in trees(BACKEND / package)
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Call)
        if ast.unparse(node.value.func).startswith(("Hooks", "Listeners"))
        for target in node.targets
        if isinstance(target, ast.Attribute)
    }


def test_an_extension_adds_only_while_it_is_open() -> None:
    names = hook_names()
    assert {"before_send", "before_removal", "sources", "until_stored", "on_end"} <= names
    for_good = [
        f"{path.relative_to(ROOT)}:{node.lineno}: {ast.unparse(node)}"
        for folder in (EXTENSIONS, ROOT / "examples")
        for path, node in trees(folder)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "append"
        if (isinstance(to := node.func.value, ast.Attribute) and to.attr in names)
        or (isinstance(to, ast.Subscript) and ast.unparse(to.value) == "parts")
    ]
    assert for_good == []
