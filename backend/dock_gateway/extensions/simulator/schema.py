"""The JSON shapes of what is asked of a simulator."""

from typing import Annotated

from pydantic import Field

from dock_gateway.http.schema import Schema

Distance = Annotated[float, Field(ge=-100, le=100)]


class PlaceBody(Schema):
    """In m and rad, in the frame `world`: the dock is at its origin, and a theta of 0 looks into it."""

    x: Distance
    y: Distance
    theta: Distance


class FaultBody(Schema):
    """Whether a fault is on."""

    active: bool
