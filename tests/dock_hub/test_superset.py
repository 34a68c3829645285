"""A hub answers what a gateway answers, and more: a program for a gateway works with a hub."""

import re
from pathlib import Path
from typing import Any

import pytest

from dock_gateway.app import create_app
from dock_gateway.core.error_codes import ErrorCode
from dock_gateway.extension import extensions
from dock_gateway.settings import Settings
from dock_gateway.streams.includes import type_of
from dock_hub.app import create_hub_app
from dock_hub.schema import GOAL_FIELDS, INCLUDES
from dock_hub.settings import HubSettings
from tests.support.compatibility import compare

PAGE = (Path(__file__).parents[2] / "docs" / "extensions" / "sites.md").read_text()
Document = dict[str, Any]


@pytest.fixture(scope="module")
def gateway() -> Document:
    return create_app(Settings()).openapi()


@pytest.fixture(scope="module")
def hub() -> Document:
    return create_hub_app(HubSettings()).openapi()


def operations(document: Document) -> set[str]:
    return {f"{method.upper()} {path}" for path, item in document["paths"].items() for method in item}


def event_types(document: Document) -> set[str]:
    return set(document["components"]["schemas"]["Event"]["discriminator"]["mapping"])


def codes(document: Document) -> dict[str, int | None]:
    return {code["code"]: code["status"] for code in document["components"]["schemas"]["Problem"]["x-codes"]}


def listed(heading: str) -> set[str]:
    """What the first column of the table below a heading of the page has as code."""
    section = PAGE.partition(f"\n### {heading}\n")[2].partition("\n#")[0]
    cells = re.findall(r"^\| (`.*?) \|", section, re.MULTILINE)
    return {name for cell in cells for name in re.findall(r"`([^`]+)`", cell)}


def test_what_both_have_differs_by_additions_only(gateway: Document, hub: Document) -> None:
    shared = operations(gateway) & operations(hub)
    assert len(shared) > 40
    paths = {
        path: {method: operation for method, operation in item.items() if f"{method.upper()} {path}" in shared}
        for path, item in gateway["paths"].items()
    }
    found = compare({**gateway, "paths": paths}, hub)
    missing = {f"Event: no longer type {name}" for name in listed("Events that a hub does not send")}
    # Those of /ws, of /ws/topics and of goals on other actions, which a hub does not have.
    missing |= {f"{name}: is gone" for name in ("Answer", "Command", "EchoEvent", "ActionEvent")}
    missing.add("GET /robots: x-robot was all, is below")  # `/berlin` is the robots of a site
    # A hub has no ROS to describe a message with. It shows the message as the site has sent it.
    unknown = re.compile(r"BatteryState\.\w+: is gone")
    assert {line for line in found.broken if not unknown.fullmatch(line)} == missing
    assert found.deprecated == []


def test_what_a_hub_does_not_have_is_listed(gateway: Document, hub: Document) -> None:
    assert operations(gateway) - operations(hub) == listed("Operations that a hub does not have")
    assert event_types(gateway) - event_types(hub) == listed("Events that a hub does not send")


def test_a_role_and_a_robot_mean_the_same(gateway: Document, hub: Document) -> None:
    for name in operations(gateway) & operations(hub):
        method, path = name.split()
        one, other = (document["paths"][path][method.lower()] for document in (gateway, hub))
        assert one.get("x-role") == other.get("x-role"), name
        if name != "GET /robots":  # of a hub, which lists those below the robot, too
            assert one.get("x-robot") == other.get("x-robot"), name


def test_a_code_has_the_status_that_it_has_at_a_gateway(gateway: Document, hub: Document) -> None:
    before, after = codes(gateway), codes(hub)
    assert {code: after[code] for code in before.keys() & after.keys()} == {
        code: before[code] for code in before.keys() & after.keys()
    }
    of_extensions = {code["code"] for code in map(ErrorCode.document, extensions().errors)}
    assert before.keys() - after.keys() <= of_extensions


def test_whatever_a_stream_of_a_gateway_can_be_asked_for() -> None:
    assert {type_of(event) for event in extensions().events} == {*INCLUDES}


def test_the_fields_that_extensions_add_to_goals() -> None:
    assert extensions().goal_fields == GOAL_FIELDS
