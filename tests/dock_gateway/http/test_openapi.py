"""The OpenAPI document describes what is really sent."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import orjson
import pytest
from openapi_spec_validator import OpenAPIV31SpecValidator, validate

from dock_gateway.app import create_app
from dock_gateway.settings import Settings
from dock_gateway.streams.socket import OPERATIONS

API_PAGE = Path(__file__).parents[3] / "docs/api.md"


def references(value: object) -> set[str]:
    if isinstance(value, dict):
        own = {value["$ref"]} if isinstance(value.get("$ref"), str) else set()
        return own.union(*(references(item) for item in value.values()))
    return set().union(*(references(item) for item in value)) if isinstance(value, list) else set()


def test_it_is_a_valid_openapi_3_1_document(document: dict[str, Any]) -> None:
    assert document["openapi"].startswith("3.1")
    validate(document, cls=OpenAPIV31SpecValidator)
    document["components"]["schemas"]["BatteryState"]["type"] = "battery"
    assert list(OpenAPIV31SpecValidator(document).iter_errors())


def test_it_asks_for_a_token_where_the_gateway_does(document: dict[str, Any]) -> None:
    assert document["security"][0] == {}
    assert document["paths"]["/healthz"]["get"]["security"] == []
    settings = Settings(authentication=True, database_url="sqlite:////nowhere")
    guarded = orjson.loads(orjson.dumps(create_app(settings).openapi()))
    validate(guarded, cls=OpenAPIV31SpecValidator)
    assert {name for option in guarded["security"] for name in option} == guarded["components"][
        "securitySchemes"
    ].keys()
    assert guarded["paths"]["/healthz"]["get"]["security"] == []


def test_every_reference_has_its_schema(document: dict[str, Any]) -> None:
    names = {f"#/components/schemas/{name}" for name in document["components"]["schemas"]}
    assert references(document) <= names


def objects(value: object) -> Iterator[dict[str, Any]]:
    """The schemas of objects with named fields below a part of the document."""
    if isinstance(value, dict):
        if value.get("type") == "object" and "properties" in value:
            yield value
        value = [*value.values()]
    if isinstance(value, list):
        for item in value:
            yield from objects(item)


def test_what_is_read_is_closed_and_what_is_sent_may_get_further_fields(document: dict[str, Any]) -> None:
    schemas = document["components"]["schemas"]
    operations = [operation for item in document["paths"].values() for operation in item.values()]
    read = [schemas[name] for name in schemas if name.endswith(("Command", "Input"))]
    read += [operation.get("requestBody", {}) for operation in operations]
    sent = [schemas[name] for name in schemas if not name.endswith(("Command", "Input"))]
    sent += [operation["responses"] for operation in operations]
    assert len([*objects(read)]) > 20
    assert len([*objects(sent)]) > 150
    assert all("additionalProperties" not in schema for schema in objects(sent))
    assert [schema for schema in objects(read) if "additionalProperties" not in schema] == []


def test_errors_are_problem_documents(document: dict[str, Any]) -> None:
    for item in document["paths"].values():
        for operation in item.values():
            for status, response in operation["responses"].items():
                if status >= "400" and status != "503":
                    assert list(response["content"]) == ["application/problem+json"], operation["operationId"]


def test_operations_that_are_about_every_robot_say_so(document: dict[str, Any]) -> None:
    assert document["paths"]["/users"]["get"]["x-every-robot"] is True
    assert "x-every-robot" not in document["paths"]["/robots"]["get"]


def test_names_and_ids_have_patterns(document: dict[str, Any]) -> None:
    for path, item in document["paths"].items():
        for operation in item.values():
            for parameter in operation.get("parameters", ()):
                if parameter["name"] in {"robot", "goal_id", "since", "until"}:
                    schema = parameter["schema"]
                    kinds = [schema, *schema.get("anyOf", ())]
                    assert any("pattern" in {**kind, **kind.get("items", {})} for kind in kinds), (path, schema)
    for path, method in (("/stop", "post"), ("/alerts/{alert_id}/acknowledgement", "put")):
        by = document["paths"][path][method]["requestBody"]["content"]["application/json"]["schema"]["properties"]["by"]
        assert by["pattern"]


def test_the_battery_comes_from_the_ros_definition(document: dict[str, Any]) -> None:
    schemas = document["components"]["schemas"]
    assert schemas["BatteryState"]["required"] == list(schemas["BatteryStateInput"]["properties"])
    assert "required" not in schemas["BatteryStateInput"]
    for name in ("BatteryState", "BatteryStateInput"):
        voltage = schemas[name]["properties"]["voltage"]
        assert voltage["description"] == "Voltage in Volts (Mandatory)"
        assert voltage["x-unit"] == "V"


@pytest.mark.parametrize(("union", "field"), [("Event", "type"), ("EchoEvent", "type"), ("Command", "op")])
def test_messages_are_told_apart_by_a_field(document: dict[str, Any], union: str, field: str) -> None:
    schemas = document["components"]["schemas"]
    kinds = [
        schemas[option["$ref"].rpartition("/")[2]]["properties"][field]["const"] for option in schemas[union]["oneOf"]
    ]
    assert len(set(kinds)) == len(kinds) > 1
    assert schemas[union]["discriminator"]["propertyName"] == field
    assert schemas[union]["discriminator"]["mapping"].keys() == set(kinds)


def test_each_command_has_its_role_and_requires_its_op(document: dict[str, Any]) -> None:
    schemas = document["components"]["schemas"]
    commands = {op: ref.rpartition("/")[2] for op, ref in schemas["Command"]["discriminator"]["mapping"].items()}
    assert commands.keys() == OPERATIONS.keys()
    for op, name in commands.items():
        assert schemas[name]["x-role"] == OPERATIONS[op].role
        assert "op" in schemas[name]["required"]
        assert schemas[name]["additionalProperties"] is False


def test_a_thing_has_one_shape_in_answers_snapshots_and_events(document: dict[str, Any]) -> None:
    fields = {name: each.get("properties", {}) for name, each in document["components"]["schemas"].items()}
    snapshot, shapes = fields["SnapshotEvent"], {"Robot": fields["Robot"]}
    for event in fields.values():
        kind = event.get("type", {}).get("const")
        if kind in snapshot:
            assert event[kind] in (snapshot[kind], *snapshot[kind].get("anyOf", ())), kind
            shapes[kind] = event[kind]
    assert shapes.keys() > {"battery", "stop", "robots", "docking"}
    assert [fields["Robot"][kind] for kind in ("battery", "stop")] == [shapes["battery"], shapes["stop"]]
    for part, whole in (("Battery", "BatteryAnswer"), ("RobotPublisher", "Publisher"), ("GoalState", "Goal")):
        assert fields[part].items() <= fields[whole].items(), part


def test_each_operation_about_a_robot_says_what_it_is_about_without_one(document: dict[str, Any]) -> None:
    said: dict[str, set[str]] = {}
    for path, item in document["paths"].items():
        for method, operation in item.items():
            named = [each for each in operation.get("parameters", ()) if each["name"] == "robot"]
            assert ("x-robot" in operation) == bool(named), f"{method} {path}: take one of the types of http/requests"
            assert all("x-robot" not in each["schema"] for each in named)
            if named:
                said.setdefault(operation["x-robot"], set()).add(f"{method.upper()} {path}")
    assert said.keys() == {"configured", "all", "below"}
    rows = re.findall(r"^\| `(configured|all|below)` \|[^|]*\|([^|]*)\|$", API_PAGE.read_text(), re.MULTILINE)
    told = {meaning: set(re.findall(r"`([A-Z]+ /[^`]*)`", operations)) for meaning, operations in rows}
    # The page names those of extensions, too, which may have been taken out.
    there = {f"{method.upper()} {path}" for path, item in document["paths"].items() for method in item}
    told = {meaning: operations & there for meaning, operations in told.items()}
    assert told == said | {"configured": set()}
