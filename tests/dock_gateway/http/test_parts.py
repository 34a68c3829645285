"""Each part that a route or another part asks for by its type is one that the gateway has, or the hub."""

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

import dock_gateway
import dock_hub
from dock_gateway.http.parts import Part, Parts, T

BACKEND = Path(dock_gateway.__file__).parent
EXTENSIONS = tuple(path for path in sorted((BACKEND / "extensions").iterdir()) if (path / "extension.py").exists())
HUB = Path(dock_hub.__file__).parent


def nodes(root: Path, without: tuple[Path, ...] = ()) -> Iterator[ast.AST]:
    """All that stands in the modules below a folder."""
    for path in sorted(root.rglob("*.py")):
        if not any(path.is_relative_to(folder) for folder in without):
            yield from ast.walk(ast.parse(path.read_text()))


def asked_for(root: Path, without: tuple[Path, ...] = ()) -> set[str]:
    """The types in `Part[Labels]`, `parts[Labels]` and `self._parts[Labels]`."""
    return {
        node.slice.id
        for node in nodes(root, without)
        if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Name) and node.slice.id[0].isupper()
        if ast.unparse(node.value).split(".")[-1].lstrip("_") in {"Part", "parts"}
    } - {T.__name__}


@cache
def made(root: Path, without: tuple[Path, ...] = ()) -> set[str]:
    """The types in `Parts({Labels: labels, …})` and `parts.add(Labels, labels)`."""
    calls = [node for node in nodes(root, without) if isinstance(node, ast.Call)]
    dicts = [call.args[0] for call in calls if ast.unparse(call.func) == Parts.__name__]
    keys = [key for each in dicts if isinstance(each, ast.Dict) for key in each.keys]
    keys += [call.args[0] for call in calls if ast.unparse(call.func) == "parts.add"]
    return {key.id for key in keys if isinstance(key, ast.Name)}


def test_the_gateway_has_each_part_that_is_asked_for() -> None:
    wanted = asked_for(BACKEND, without=EXTENSIONS)
    assert {"Goals", "Stopper", "RobotRegistry"} <= wanted, f"nothing was found that reads as {Part.__name__}[...]"
    assert wanted <= made(BACKEND, without=EXTENSIONS)


@pytest.mark.parametrize("folder", EXTENSIONS, ids=lambda folder: folder.name)
def test_an_extension_asks_for_what_the_gateway_has_or_for_its_own_part(folder: Path) -> None:
    own = {node.name for node in nodes(folder) if isinstance(node, ast.ClassDef)}
    assert asked_for(folder) - made(BACKEND, without=EXTENSIONS) <= own


def test_the_hub_has_each_part_that_its_own_modules_ask_for() -> None:
    assert asked_for(HUB) <= made(HUB) | made(BACKEND / "access") | made(BACKEND / "audit")
