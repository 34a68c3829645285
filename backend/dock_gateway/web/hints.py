"""Adds to an error what is on the ROS graph, where a robot has no docking server."""

from collections.abc import Iterator
from contextlib import contextmanager

from dock_gateway.core.errors import GatewayError
from dock_gateway.core.grant import Grant
from dock_gateway.fleet.hints import Hint, docking_hint
from dock_gateway.gateway import Gateway
from dock_gateway.robots.registry import normalize_namespace

# The errors of a robot that is not there, or has no docking server.
CODES = frozenset({"action_not_found", "action_server_unavailable", "robot_not_found"})


@contextmanager
def hinting(gateway: Gateway, robot: str | None, grant: Grant) -> Iterator[None]:
    """Add a hint to the error that a robot is not there or has no docking server.

    Args:
        gateway: The gateway.
        robot: The robot's namespace; None for the configured one.
        grant: Only what it covers is named.

    Raises:
        GatewayError: What was raised within, with the hint in its detail, and `settings` and `robots`.
    """
    try:
        yield
    except GatewayError as error:
        if error.code in CODES and (hint := find_hint(gateway, robot, grant)) is not None:
            error.detail = f"{error.detail}. {hint.detail}"
            error.extra.update(settings=hint.settings, robots=hint.robots)
        raise


def find_hint(gateway: Gateway, robot: str | None, grant: Grant) -> Hint | None:
    """Return the hint for a robot; None if nothing on the graph helps."""
    name = gateway.robots.default_namespace if robot is None else normalize_namespace(robot)
    return docking_hint(name, gateway.fleet.sights(grant))
