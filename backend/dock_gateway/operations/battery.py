"""Publishing battery states instead of a robot's battery driver."""

from dataclasses import dataclass
from typing import Any

from dock_gateway.core.access import Principal
from dock_gateway.core.errors import FieldError, InvalidField, got
from dock_gateway.core.goal import Json
from dock_gateway.core.grant import Role
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Parts
from dock_gateway.robots.battery import BatteryPublisher
from dock_gateway.robots.registry import RobotRegistry

MIN_RATE, MAX_RATE, USUAL_RATE = 0.1, 100.0, 1.0


@dataclass(frozen=True)
class PublishBattery:
    """A battery state to publish.

    Attributes:
        state: Its fields, as decoded JSON; floats that are left out are NaN.
        robot: The robot; None: the configured one.
        path: Where the state was in the request, for errors.
    """

    state: Any
    robot: str | None = None
    path: str = ""


@operation(Role.SUPERVISOR, Scope.ROBOT, errors=(404, 409))
async def publish_battery(parts: Parts, _: Principal, order: PublishBattery) -> Json:
    """Publish a battery state once. Return the message as JSON.

    Raises:
        GatewayError: There is no such robot, the state is not valid, or the gateway publishes repeatedly.
    """
    return await parts[RobotRegistry].get(order.robot).publisher.publish(order.state, order.path)


@dataclass(frozen=True)
class StartPublishing:
    """A battery state to publish repeatedly, in place of the one before; `rate_hz` is messages per second."""

    state: Any
    rate_hz: Any = USUAL_RATE
    robot: str | None = None


@operation(Role.SUPERVISOR, Scope.ROBOT, errors=(404, 409))
async def start_publishing(parts: Parts, _: Principal, order: StartPublishing) -> BatteryPublisher:
    """Publish a battery state until that is stopped. Return the publisher.

    Raises:
        GatewayError: There is no such robot, or the rate or the state is not valid.
    """
    publisher = parts[RobotRegistry].get(order.robot).publisher
    await publisher.start(order.state, read_rate(order.rate_hz))
    return publisher


@operation(Role.SUPERVISOR, Scope.ROBOT, errors=(404,))
async def stop_publishing(parts: Parts, _: Principal, robot: str | None) -> BatteryPublisher:
    """Stop publishing battery states. Return the publisher.

    Raises:
        NotFound: There is no such robot.
    """
    publisher = parts[RobotRegistry].get(robot).publisher
    await publisher.stop()
    return publisher


def read_rate(value: object) -> float:
    """Return a publishing rate, in messages per second.

    Raises:
        InvalidField: The value is not a number in range.
    """
    if not isinstance(value, int | float) or isinstance(value, bool) or not MIN_RATE <= value <= MAX_RATE:
        expected = f"a number from {MIN_RATE:g} to {MAX_RATE:g}"
        raise InvalidField([FieldError("rate_hz", expected, got(value))])
    return float(value)
