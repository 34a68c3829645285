"""Each promise is on a page under its name. Settings, commands, codes and metrics have tests of their own, too."""

import re
from functools import cache
from pathlib import Path
from typing import Any

import orjson

from tests.support.compatibility import METHODS
from tests.support.contract import HUB, frozen_gateway, read

ROOT = Path(__file__).parents[2]


@cache
def pages() -> str:
    """The text of all pages."""
    return "\n".join(page.read_text() for page in (ROOT / "README.md", *(ROOT / "docs").rglob("*.md")))


def missing(names: set[str]) -> list[str]:
    """The names that no page has, in code."""
    return sorted(name for name in names if not re.search(rf'["`/ ]{re.escape(name)}[`" ?/]', pages()))


def of_kind(method: str) -> set[str]:
    """The names of the operations of one kind."""
    return {name for name, item in frozen_gateway()["paths"].items() if method in item}


def names(prefix: str) -> set[str]:
    """The names of one kind that are no operations."""
    return {name.removeprefix(prefix) for name in frozen_gateway()["names"] if name.startswith(prefix)}


def test_each_operation_is_described_and_what_it_is_about_is_on_a_page() -> None:
    document: dict[str, Any] = orjson.loads((ROOT / "frontend/openapi.json").read_bytes())
    promised = {path for path, item in frozen_gateway()["paths"].items() if not item.keys().isdisjoint(METHODS)}
    for path in promised:
        for method, operation in document["paths"][path].items():
            assert operation.get("description"), f"{method} {path}"
    # A browser is sent to this one by the identity provider.
    assert missing({path.partition("/{")[0] for path in promised} - {"/session/oidc/callback"}) == []


def test_each_command_is_on_a_page() -> None:
    assert missing({name.split()[1] for name in of_kind("run")}) == []


def test_each_tool_of_agents_is_on_a_page() -> None:
    assert missing(of_kind("call")) == []


def test_each_setting_is_on_a_page() -> None:
    settings = frozen_gateway()["paths"]["settings"]["set"]["requestBody"]["content"]["application/json"]["schema"]
    assert missing({f"DOCK_GATEWAY_{name.upper()}" for name in settings["properties"]}) == []


def test_each_message_of_a_stream_is_on_a_page() -> None:
    types = {kind for name, kind in frozen_gateway()["names"].items() if name.startswith("/")}
    assert len(types) > 20
    assert missing(types) == []


def test_each_code_and_each_metric_is_on_a_page() -> None:
    assert missing(names("error ") | names("metric ")) == []


def test_metrics_are_named_by_the_conventions_of_prometheus() -> None:
    """What only grows is a `_total`, units are base units, and no name has the type in it."""
    promised = frozen_gateway()["names"] | read(HUB)["names"]
    found = {name: kind for name, kind in promised.items() if name.startswith("metric ")}
    assert len(found) > 30
    assert [name for name, kind in found.items() if name.endswith("_total") is not (kind == "counter")] == []
    assert [name for name, kind in found.items() if kind == "histogram" and not name.endswith("_seconds")] == []
    odd = re.compile("milli|micro|minute|hour|day|_ms|_mb|percent|counter|gauge|histogram|summary|[A-Z]")
    assert [name for name in found if odd.search(name)] == []
