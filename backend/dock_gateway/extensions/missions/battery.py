"""When the robot of a mission returns to charge, as clients send it."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from dock_gateway.http.bodies import expected
from dock_gateway.http.schema import Schema

# What lies between the two charges at least: else a robot would drive between its work and its dock all the time.
LEAST_CHARGE = 0.05


class BatteryLimits(Schema):
    """Below which charge the robot returns to its dock, and to which it charges there: 0 to 1.

    `charge_to` is 0.05 above `below` at least.
    """

    below: Annotated[float, Field(gt=0, le=0.95, description="Charge, 0 to 1")]
    charge_to: Annotated[float, Field(gt=0, le=1, description="Charge, 0 to 1")]

    @model_validator(mode="after")
    def _are_apart(self) -> Self:
        if round(self.charge_to - self.below, 6) < LEAST_CHARGE:
            raise expected("a charge_to that is 0.05 above below at least", path="charge_to")
        return self
