"""Every link in the documentation leads to a file and a heading, and the architecture names files that are there."""

import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
INDEX = ROOT / "docs/index.md"
EXTENSIONS = ROOT / "docs/extensions"
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").rglob("*.md"))]


def anchors(page: Path) -> set[str]:
    """The names of a page's headings in links, as GitHub makes them."""
    headings = re.findall(r"(?m)^#+ (.*)$", page.read_text())
    texts = (re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower() for heading in headings)
    return {re.sub(r"[^\w\- ]", "", text).replace(" ", "-") for text in texts}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_leads_somewhere(page: Path) -> None:
    for link in re.findall(r"\]\(([^)\s]+)\)", page.read_text()):
        path, _, anchor = link.partition("#")
        if ":" in path:
            continue
        target = page.parent / path if path else page
        assert target.exists(), link
        assert not anchor or target.suffix != ".md" or anchor in anchors(target), link


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_a_table_has_no_gap(page: Path) -> None:
    """What follows an empty line is no row of the table above."""
    for table in re.findall(r"(?m)(?:^\|.*\n)+", page.read_text()):
        assert re.fullmatch(r"\|[-:| ]+\|", ([*table.splitlines(), ""])[1]), table.splitlines()[0]


def test_the_index_and_the_navigation_list_every_page_once_in_the_same_order() -> None:
    navigation = str(tomllib.loads((ROOT / "zensical.toml").read_text())["project"]["nav"])
    listed = re.findall(r"'([\w/-]+\.md)'", navigation)
    generated = {"docs/operations.md", "docs/schemas.md", "docs/files.md", "docs/modules.md"}
    links = re.findall(r"(?m)^\| \[[^\]]*\]\(([^)]+)\)", INDEX.read_text())
    pages = [str((INDEX.parent / link).resolve().relative_to(ROOT)) for link in links]
    assert pages == [page for page in listed if page not in {*generated, "README.md", "docs/index.md"}]
    assert sorted({*listed} - generated) == sorted(str(page.relative_to(ROOT)) for page in PAGES)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_the_page_of_an_extension_can_be_removed(page: Path) -> None:
    """It is named by the index, by itself and its further pages (`sites-nats.md`), and by the rows of its settings."""
    if page == INDEX:
        return
    lines = [line for line in page.read_text().splitlines() if not line.startswith("| `DOCK_GATEWAY_")]
    links = re.findall(r"\]\(([^)\s:#]+\.md)", "\n".join(lines))
    targets = [(page.parent / link).resolve() for link in links]
    own = page.stem.partition("-")[0] if page.parent == EXTENSIONS else None
    assert [
        target.name for target in targets if target.parent == EXTENSIONS and target.stem.partition("-")[0] != own
    ] == []


def test_the_files_that_the_architecture_names_are_there() -> None:
    page = (ROOT / "docs/architecture.md").read_text()
    names = re.findall(r"`((?:\w+/)+\w+\.py)`", page)
    roots = (ROOT / "backend", ROOT / "backend/dock_gateway")
    assert len(names) > 15
    assert [name for name in names if not any((root / name).exists() for root in roots)] == []


@pytest.mark.parametrize("folder", ["backend/dock_gateway", "backend/dock_hub", "frontend/src"])
def test_the_architecture_names_what_is_in_a_folder(folder: str) -> None:
    page = (ROOT / "docs/architecture.md").read_text()
    named = {name.strip("/").split("/")[0] for name in re.findall(r"`([\w./]+)`", page)}
    for path in (ROOT / folder).iterdir():
        if path.is_dir() and all("__pycache__" in each.parts for each in path.rglob("*") if each.is_file()):
            continue  # what was deleted may have left its compiled modules
        if path.suffix in ("", ".py", ".ts", ".tsx") and path.is_file() == bool(path.suffix) and "__" not in path.name:
            assert {path.name, path.stem} & named, path.name


def layers_of(heading: str) -> list[str]:
    """Return the packages, modules and folders that a table of the architecture has, in its order."""
    page = (ROOT / "docs/architecture.md").read_text()
    section = page.partition(f"\n## {heading}\n")[2].partition("\n## ")[0]
    cells = re.findall(r"^\| (`.*?`) \|", section, re.MULTILINE)
    names = [name.removesuffix(".py") for cell in cells for name in re.findall(r"`([^`]+)`", cell)]
    return [name.split("/")[0] for name in names]


def test_the_architecture_has_the_gateways_layers_in_their_order() -> None:
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    (layers,) = [each["layers"] for each in contracts if each["name"] == "the gateway's layers"]
    height = {name: at for at, layer in enumerate(layers) for name in layer.split(" | ")}
    assert height.pop("__main__") == 0
    shown = layers_of("The gateway's layers")
    assert sorted(shown) == sorted(height)
    assert shown == sorted(shown, key=height.__getitem__)


def test_the_architecture_has_the_dashboards_layers_in_their_order() -> None:
    source = (ROOT / "frontend/layers.mjs").read_text().partition("const LAYERS = [")[2].partition("\n];")[0]
    layers = dict.fromkeys(name.split("/")[0] for name in re.findall(r'"([^"]+)"', source))
    shown = [name for name in layers_of("Inside the dashboard") if name not in ("..", "extensions")]
    assert shown == [*layers]
