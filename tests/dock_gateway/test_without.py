"""`scripts/without` takes an extension out of a copy, and no page says anything about it any more."""

import importlib.machinery
import importlib.util
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from dock_gateway.extension import find_extension
from dock_gateway.extension_list import OURS

ROOT = Path(__file__).parents[2]
COPIED = ("backend/dock_gateway", "docs", "frontend/src/extensions", "frontend/src/extensions.ts", "zensical.toml")


def load() -> Callable[[str, Path], list[str]]:
    loader = importlib.machinery.SourceFileLoader("without", str(ROOT / "scripts/without"))
    spec = importlib.util.spec_from_loader("without", loader)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    loader.exec_module(module)
    take_out: Callable[[str, Path], list[str]] = module.take_out
    return take_out


def copied(folder: Path) -> Path:
    for path in COPIED:
        copy = shutil.copytree if (ROOT / path).is_dir() else shutil.copy
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        copy(ROOT / path, folder / path)
    return folder


@pytest.mark.parametrize("name", ["access", "nothing"])
def test_what_is_no_extension_of_the_gateway_stays(name: str, tmp_path: Path) -> None:
    copy = copied(tmp_path)
    before = {path: path.read_bytes() for path in copy.rglob("*") if path.is_file()}
    with pytest.raises(LookupError, match=f"has no extension {name}: only those that it names"):
        load()(name, copy)
    assert before == {path: path.read_bytes() for path in copy.rglob("*") if path.is_file()}


@pytest.mark.parametrize("name", OURS)
def test_no_page_names_the_tests_or_the_page_of_an_extension_that_is_taken_out(name: str, tmp_path: Path) -> None:
    removed = load()(name, copy := copied(tmp_path))
    assert f"backend/dock_gateway/extensions/{name}" in removed
    pages = {page.name: page.read_text() for page in (copy / "docs").glob("*.md")}
    rows = [line for text in pages.values() for line in text.splitlines() if line.startswith("| ")]
    assert [row for row in rows if f"extensions/{name}" in row and "`DOCK_GATEWAY_" not in row] == []
    assert len(rows) > 300
    for alert in find_extension(name).alerts:
        assert not [row for row in rows if row.startswith(f"| `{alert.value}`")]
