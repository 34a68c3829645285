"""The services that read the file of docks again: `reload_docks`, and nav2's `~/reload_database`."""

from typing import Any

from rclpy.node import Node
from std_srvs.srv import Trigger

from docking.ros.parameters import DeclaredParameters

try:
    from nav2_msgs.srv import ReloadDockDatabase
except ImportError:  # not on PyPI
    ReloadDockDatabase = None

SHOWN = 20
"""Docks that an answer names."""


class DockReloader:
    """Offers the services. A goal that runs keeps its dock; the next one goes by the new ones."""

    def __init__(self, node: Node, parameters: DeclaredParameters[Any]) -> None:
        """Offer them.

        Args:
            node: The node that has the parameters.
            parameters: With the file of docks.
        """
        self._node = node
        self._parameters = parameters
        node.create_service(Trigger, "reload_docks", self._reload)
        if ReloadDockDatabase is not None:
            node.create_service(ReloadDockDatabase, "~/reload_database", self._reload_from)

    def _reload(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success, response.message = self.read("")
        return response

    def _reload_from(self, request: Any, response: Any) -> Any:
        response.success, _ = self.read(request.filepath)
        return response

    def read(self, path: str) -> tuple[bool, str]:
        """Read a file of docks, the same again if the path is empty; whether it counts, and what to say about it."""
        try:
            docks = self._parameters.reload(path)
        except ValueError as error:
            self._node.get_logger().error(f"The docks are as before: {error}")
            return False, f"the docks are as before: {error}"
        more = f" and {len(docks) - SHOWN} more" if len(docks) > SHOWN else ""
        known = f"{len(docks)} dock{'s' * (len(docks) != 1)}: {', '.join(docks[:SHOWN])}{more}"
        self._node.get_logger().info(f"Read {known}")
        return True, known
