"""What tests share is in modules of its own: a module of tests is nobody's library."""

import ast
from pathlib import Path

import pytest
from scripts.mutation import AREAS

TESTS = Path(__file__).parents[1]


def imported(source: str) -> set[str]:
    """Return the modules of ours that a source names, and what it takes from them."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            start = "." * node.level + (node.module or "")
            names |= {f"{start}.{alias.name}" for alias in node.names}
    return {name for name in names if name.startswith(("tests.", "."))}


def modules_of_tests(source: str) -> set[str]:
    """Return what a source imports of modules that hold tests."""
    return {name for name in imported(source) if any(part.startswith("test_") for part in name.split("."))}


def test_nothing_imports_a_module_of_tests() -> None:
    found = {str(file.relative_to(TESTS)): modules_of_tests(file.read_text()) for file in TESTS.rglob("*.py")}
    assert len(found) > 300
    assert {file: names for file, names in found.items() if names} == {}


@pytest.mark.parametrize(
    "source",
    [
        "from tests.system.test_gateway_exit import GONE_WITHIN",
        "from tests.system import test_gateway_exit as ends",
        "import tests.system.test_gateway_exit",
        "def late():\n    from .test_gateway_exit import GONE_WITHIN",
    ],
)
def test_each_way_to_import_one_is_noticed(source: str) -> None:
    assert modules_of_tests(source)
    assert not modules_of_tests("from test_msgs.action import Fibonacci")


@pytest.mark.parametrize("area", AREAS)
def test_the_mutated_modules_and_their_tests_are_there(area: str) -> None:
    modules, tests = AREAS[area]
    root = TESTS.parent
    missing = [path for path in (*(f"backend/{module}" for module in modules), *tests) if not (root / path).exists()]
    assert modules
    assert missing == []
