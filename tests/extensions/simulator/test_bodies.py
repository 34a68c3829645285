"""A body is what its schema says."""

from typing import Any

import pytest
from pydantic import BaseModel

from dock_gateway.extensions.simulator.schema import FaultBody, PlaceBody
from tests.support.bodies import expect_refused


@pytest.mark.parametrize(
    ("model", "example"), [(PlaceBody, {"x": 1.0, "y": 0.0, "theta": 0.5}), (FaultBody, {"active": True})]
)
def test_what_the_schema_does_not_allow_is_refused_where_it_is_wrong(
    model: type[BaseModel], example: dict[str, Any]
) -> None:
    expect_refused(model, example)
