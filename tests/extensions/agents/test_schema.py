"""The arguments of tools."""

import pytest

from dock_gateway.access.tool import Nothing
from dock_gateway.core.errors import InvalidField
from dock_gateway.http.bodies import read_model


def test_a_body_without_fields_takes_none() -> None:
    with pytest.raises(InvalidField) as refused:
        read_model(Nothing, {"x": 1})
    assert refused.value.extra["errors"] == [
        {"in": "body", "path": "x", "expected": "no field", "detail": "got an unknown field"}
    ]
