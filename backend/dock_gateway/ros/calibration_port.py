"""The service `calibrate_dock` of a robot's docking server."""

from std_srvs.srv import Trigger

from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.service_client import ServiceClient

# Seconds to wait for an answer. A calibration takes up to 10 s.
ANSWER_WITHIN = 16.0


class CalibrationPort:
    """A client of the service, created on first use.

    Args:
        bridge: The bridge to the ROS thread.
        service: Absolute name.
    """

    def __init__(self, bridge: Bridge, service: str) -> None:
        self.service = service
        self._client = ServiceClient(bridge, Trigger, service)

    async def is_offered(self) -> bool:
        """Return whether the service is on the graph.

        Raises:
            Unavailable: The ROS thread is down.
        """
        return await self._client.is_offered()

    async def calibrate(self) -> tuple[bool, str]:
        """Return whether the dock was calibrated, and the server's text.

        Raises:
            TimeoutError: The server did not answer.
            Unavailable: The service is not there, or the ROS thread is down.
        """
        answer = await self._client.call(Trigger.Request(), ANSWER_WITHIN)
        return answer.success, answer.message
