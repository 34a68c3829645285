"""How docking servers read their file of docks again."""

from pathlib import Path

from std_srvs.srv import Trigger

from dock_gateway.core.dock_adapters.nav2 import FAMILY as NAV2
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.service_client import ServiceClient

try:
    from nav2_msgs.srv import ReloadDockDatabase
except ImportError:  # not on PyPI
    ReloadDockDatabase = None

# Seconds in which a server reads the file.
READ_WITHIN = 5.0


class ReloadPort:
    """Calls `reload_docks` of our own servers, and `reload_database` of nav2's.

    Args:
        bridge: Runs calls on the ROS thread.
    """

    def __init__(self, bridge: Bridge) -> None:
        self._bridge = bridge

    async def reload(self, node: str, family: str, path: Path) -> str:
        """Have a docking server read its file; return why it has not, empty if it has.

        Args:
            node: Full name of the server's node.
            family: Who defines its type.
            path: The file.

        Raises:
            Unavailable: It is gone, or the ROS thread is down.
        """
        kind, name, request = Trigger, f"{node.rpartition('/')[0]}/reload_docks", Trigger.Request()
        if family == NAV2:
            if ReloadDockDatabase is None:
                return "nav2_msgs is not installed at the gateway"
            kind, name = ReloadDockDatabase, f"{node}/reload_database"
            request = ReloadDockDatabase.Request(filepath=str(path))
        client = ServiceClient(self._bridge, kind, name)
        try:
            answer = await client.call(request, READ_WITHIN)
        except TimeoutError:
            return f"{name} does not answer"
        finally:
            client.close()
        return "" if answer.success else str(getattr(answer, "message", "")) or f"{name} has refused it"
