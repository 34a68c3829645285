"""Finds where the source bounds something: refusals because of a number, places, threads, what is kept."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import dock_gateway
import dock_hub

ROOT, OF_HUB = (Path(each.__file__).parent for each in (dock_gateway, dock_hub))
# What waits for its turn or refuses: of one process, and so of all its users.
PLACES = {
    "Semaphore",
    "BoundedSemaphore",
    "ThreadPoolExecutor",
    "ProcessPoolExecutor",
    "TooManyRequests",
    "limit_reached",
}
CODE = re.compile(r"too_many_\w*")
NUMBER = re.compile(r"_?(MAX|MOST|KEEP|KEPT)_?|.*_(most|max_\w+|limits)$|.*(AT_ONCE|REMEMBERED|WAITING|HARD_LIMIT)$")
# These have no users: programs of their own, and what only translates.
NOT_SHARED = ("cli", "client", "doctor")


def bounds(root: Path = ROOT) -> set[str]:
    """Return what bounds something, as `module:function`."""
    found = set()
    for path in sorted(root.rglob("*.py")):
        name = ".".join(path.relative_to(root).with_suffix("").parts)
        if not name.startswith(NOT_SHARED):
            found |= {f"{name}:{where}" for where in _in(ast.parse(path.read_text()), "")}
    return found


def _in(node: ast.AST, where: str) -> Iterator[str]:
    for child in ast.iter_child_nodes(node):
        named = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)
        inner = f"{where}.{child.name}".lstrip(".") if named else where
        if _bounds(child):
            yield where
        yield from _in(child, inner)


def _bounds(node: ast.AST) -> bool:
    match node:
        case ast.Call(func=ast.Name(id=name) | ast.Attribute(attr=name)) if name in PLACES:
            return True
        case ast.keyword(arg="code", value=value):
            return any(isinstance(each, ast.Constant) and bool(CODE.match(str(each.value))) for each in ast.walk(value))
        case ast.Compare(left=left, comparators=[right]):
            return _is_size(left) and _is_number(right)
    return False


def _is_size(node: ast.expr) -> bool:
    """Whether it is the length of what an object has."""
    for each in ast.walk(node):
        match each:
            case ast.Call(func=ast.Name(id="len"), args=[argument]):
                if any(isinstance(one, ast.Name) and one.id == "self" for one in ast.walk(argument)):
                    return True
    return False


def _is_number(node: ast.expr) -> bool:
    """Whether it is a limit."""
    return any(
        isinstance(each, ast.Name | ast.Attribute)
        and bool(NUMBER.match(each.id if isinstance(each, ast.Name) else each.attr))
        for each in ast.walk(node)
    )


if __name__ == "__main__":
    print(*sorted(bounds()), sep="\n")
