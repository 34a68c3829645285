"""The AsyncAPI document has every message of the streams and of `/ws`, and holds together."""

from functools import reduce
from typing import Any

import orjson
import pytest
from click.testing import CliRunner
from starlette.testclient import TestClient

from dock_gateway.app import create_app
from dock_gateway.cli import main
from dock_gateway.settings import Settings

Json = dict[str, Any]


@pytest.fixture(scope="module")
def client() -> TestClient:
    return TestClient(create_app(Settings(authentication=True)), base_url="http://127.0.0.1:8000")


@pytest.fixture(scope="module")
def openapi(client: TestClient) -> Json:
    document: Json = client.get("/openapi.json").json()
    return document


@pytest.fixture(scope="module")
def asyncapi(client: TestClient) -> Json:
    document: Json = client.get("/asyncapi.json").json()
    return document


def references(value: object) -> set[str]:
    if isinstance(value, dict):
        own = {value["$ref"]} if isinstance(value.get("$ref"), str) else set()
        return own.union(*(references(item) for item in value.values()))
    return set().union(*(references(item) for item in value)) if isinstance(value, list) else set()


def find(document: Json, reference: str) -> Any:
    return reduce(lambda value, name: value[name], reference.removeprefix("#/").split("/"), document)


def names(messages: list[Json]) -> set[str]:
    return {message["$ref"].rpartition("/")[2] for message in messages}


def test_every_reference_leads_to_something(asyncapi: Json) -> None:
    for reference in references(asyncapi):
        assert isinstance(find(asyncapi, reference), dict)
    used = {reference.rpartition("/")[2] for reference in references(asyncapi)}
    for kind in ("messages", "schemas", "securitySchemes"):
        assert asyncapi["components"][kind].keys() <= used


def test_the_messages_are_those_of_the_openapi_document(asyncapi: Json, openapi: Json) -> None:
    schemas = openapi["components"]["schemas"]

    def of(*unions: str) -> set[str]:
        return {name for union in unions for name in names(schemas[union].get("oneOf") or schemas[union]["anyOf"])}

    channels = asyncapi["channels"]
    assert channels["socket"]["messages"].keys() == of("Command", "Answer", "Event", "ActionEvent")
    assert channels["feedback"]["messages"].keys() == of("Event", "ActionEvent")
    assert channels["topics"]["messages"].keys() == of("EchoEvent")
    for name, schema in asyncapi["components"]["schemas"].items():
        assert schema == schemas[name]
    for name, message in asyncapi["components"]["messages"].items():
        properties = schemas[name]["properties"]
        assert message["name"] == (properties.get("op") or properties["type"])["const"]


def test_each_stream_of_server_sent_events_is_a_channel(asyncapi: Json, openapi: Json) -> None:
    streams = {path for path in openapi["paths"] if path.endswith("/events")}
    channels = [channel for channel in asyncapi["channels"].values() if channel["address"] in streams]
    assert len(channels) == len(streams) == 1
    for channel in channels:
        assert {f"{{{name}}}" for name in channel["parameters"]} <= {*channel["address"].split("/")}
        assert {"SnapshotEvent", "FeedbackEvent", "ActionResultEvent"} <= channel["messages"].keys()
        assert "RobotsEvent" not in channel["messages"]


def test_each_command_has_its_role_and_its_answers(asyncapi: Json, openapi: Json) -> None:
    schemas = openapi["components"]["schemas"]
    answers = set()
    for op, command in schemas["Command"]["discriminator"]["mapping"].items():
        operation = asyncapi["operations"][op]
        assert (operation["action"], operation["x-role"]) == ("receive", find(openapi, command)["x-role"])
        assert names(operation["messages"]) == {command.rpartition("/")[2]}
        answers |= names(operation["reply"]["messages"])
    assert answers == names(schemas["Answer"]["anyOf"])


def test_it_is_printed_and_without_logins_needs_none(asyncapi: Json) -> None:
    assert len(asyncapi["servers"]["websockets"]["security"]) == 3
    assert len(asyncapi["servers"]["http"]["security"]) == 2
    printed = CliRunner().invoke(main, ["schema", "asyncapi"])
    assert printed.exit_code == 0, printed.output
    document = orjson.loads(printed.output)
    assert document["servers"]["websockets"]["security"] == []
    assert document["channels"].keys() == asyncapi["channels"].keys()
