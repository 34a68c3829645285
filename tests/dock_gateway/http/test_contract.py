"""What clients rely on does not change by accident."""

from pathlib import Path
from typing import Any

import pytest

from tests.support.contract import contract

STORED = Path(__file__).with_name("contract.txt")


def test_the_contract_is_as_it_was(document: dict[str, Any]) -> None:
    before, now = STORED.read_text().splitlines(), contract(document)
    changes = [f"- {line}" for line in before if line not in now] + [f"+ {line}" for line in now if line not in before]
    assert not changes, f"if clients may notice this, run: python -m tests.support.contract > {STORED.name}"


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("paths", "/dock", "post", "x-role"), "viewer"),
        (("paths", "/battery/publisher", "put", "requestBody", "required"), False),
        (("components", "schemas", "Robot", "properties", "name", "type"), "integer"),
        (("components", "schemas", "GoalStatus", "enum"), ["pending"]),
    ],
)
def test_a_change_is_seen(document: dict[str, Any], path: tuple[str, ...], value: object) -> None:
    before, inner = contract(document), document
    for key in path[:-1]:
        inner = inner[key]
    assert path[-1] in inner
    inner[path[-1]] = value
    assert contract(document) != before


def test_how_the_document_is_written_is_no_change(document: dict[str, Any]) -> None:
    """A body may become a component, and null be written otherwise."""
    before = [line for line in contract(document) if line.startswith("PUT /users/")]
    content = document["paths"]["/users/{user}"]["put"]["requestBody"]["content"]["application/json"]
    document["components"]["schemas"]["UserIn"] = content["schema"]
    password = content["schema"]["properties"]["password"]
    content["schema"]["properties"]["password"] = {"anyOf": [password | {"type": "string"}, {"type": "null"}]}
    content["schema"] = {"$ref": "#/components/schemas/UserIn"}
    assert [line for line in contract(document) if line.startswith("PUT /users/")] == before
