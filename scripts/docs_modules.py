"""A page of the documentation site: each module of the backend, with the first paragraph of its docstring."""

import ast
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path

HEAD = """# Modules

Every module of the backend, as its docstring describes it. [Architecture](architecture.md)
says how the folders depend on each other.
"""
PACKAGES = ["dock_gateway", "dock_hub", "docking", "robot_io"]


def summary(path: Path) -> str:
    """The first paragraph of a module's docstring, as a cell of a table."""
    text = ast.get_docstring(ast.parse(path.read_text())) or ""
    return " ".join(text.partition("\n\n")[0].split()).replace("|", "\\|")


def sections(backend: Path) -> Iterator[str]:
    """A table for each folder, below what its package says of itself."""
    paths = sorted(path for package in PACKAGES for path in (backend / package).rglob("*.py"))
    for folder, modules in groupby(sorted(paths, key=lambda path: path.parent), key=lambda path: path.parent):
        found = {path.stem: summary(path) for path in modules}
        about = found.pop("__init__", "")
        rows = "".join(f"| `{name}` | {text} |\n" for name, text in found.items())
        yield f"\n## {folder.relative_to(backend)}\n\n{about}\n" + (
            f"\n| module | |\n|---|---|\n{rows}" if rows else ""
        )


def modules_page(backend: Path) -> str:
    """The page, as Markdown."""
    return HEAD + "".join(sections(backend))
