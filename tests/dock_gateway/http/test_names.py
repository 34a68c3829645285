"""Times, ids and schemas of the documents, of a gateway and of a hub, have names by docs/compatibility.md."""

import re
from collections.abc import Iterator
from typing import Any

import pytest

from dock_gateway.app import create_app
from dock_gateway.settings import Settings
from dock_hub.app import create_hub_app
from dock_hub.settings import HubSettings

# `time` is when an event happened; `timestamp` is of Standard Webhooks; `since` and `until` are the span of the query.
TIMES = {"time", "timestamp", "since", "until"}
# Leaks of Python and pydantic, and names that say nothing outside of their module.
LEAKS = re.compile(r"__|-Input$|-Output$|^(Kind|Mode|Wait|Use|Outcome|State|Type|NoAlert)$")


def documents() -> Iterator[dict[str, Any]]:
    yield create_app(Settings()).openapi()
    yield create_hub_app(HubSettings(nats="nats://127.0.0.1")).openapi()


@pytest.fixture(scope="module", params=["gateway", "hub"])
def schemas(request: pytest.FixtureRequest) -> dict[str, Any]:
    found: dict[str, Any] = [*documents()][request.param == "hub"]["components"]["schemas"]
    return {name: schema for name, schema in found.items() if "." not in name}  # of ROS


def fields(schemas: dict[str, Any]) -> Iterator[tuple[str, str, dict[str, Any]]]:
    for model, schema in schemas.items():
        for name, field in schema.get("properties", {}).items():
            yield model, name, field


def test_each_time_ends_in_at(schemas: dict[str, Any]) -> None:
    times = [(model, name) for model, name, field in fields(schemas) if "date-time" in str(field)]
    assert len(times) > 20
    assert [found for found in times if not found[1].endswith("_at") and found[1] not in TIMES] == []
    assert [name for _, name, _ in fields(schemas) if name in {"at", "stamp"}] == []


def test_the_id_of_a_thing_is_id(schemas: dict[str, Any]) -> None:
    """But for goals and docks, whose `goal_id` and `dock_id` are ROS's. `x_id` is the id of another thing."""
    own = {"Note": "note_id", "Approval": "approval_id", "AuditRecord": "entry_id", "Rule": "rule_id"}
    assert [(model, name) for model, name, _ in fields(schemas) if own.get(model) == name] == []


def test_schemas_have_names_that_say_what_they_are(schemas: dict[str, Any]) -> None:
    assert [name for name in schemas if LEAKS.search(name)] == []
