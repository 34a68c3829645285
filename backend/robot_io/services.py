"""Services that always answer."""

import inspect
from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.service import Service


def always_answer(node: Node, log: Callable[[str], object]) -> None:
    """Let no request end the process: one on which a callback raises is logged, and gets the default response.

    rclpy's own callbacks raise on a transition that the lifecycle state does not allow, and on a parameter of an
    unknown type.

    Args:
        node: The node, with all services that it has so far. It must not be spinning.
        log: Logs an error; it is called while the exception is handled.
    """
    for service in node.services:
        _wrap(service, log)


def _wrap(service: Service, log: Callable[[str], object]) -> None:
    callback = service.callback

    async def answer(request: Any, response: Any) -> Any:
        try:
            answered = callback(request, response)
            return await answered if inspect.isawaitable(answered) else answered
        except Exception as error:  # noqa: BLE001 - whatever the requests of others bring about
            log(f"A request to {service.srv_name} failed: {error}")
            return response

    service.callback = answer
