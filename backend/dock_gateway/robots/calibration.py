"""Calibration of docks: the docking server of a robot that stands on its dock measures where that is."""

import re
from functools import partial
from typing import Any

from dock_gateway.core.errors import Conflict, NotInstalled, ServerTimeout
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.calibration_port import CalibrationPort
from dock_gateway.settings import Settings

SERVICE = "calibrate_dock"
# A parameter in the server's YAML, with its previous value in the comment.
PARAMETER = re.compile(
    r"^ +([\w.-]+): (-?\d+(?:\.\d+)?(?:e-?\d+)?) +# before: (-?\d+(?:\.\d+)?(?:e-?\d+)?)$", re.MULTILINE
)


class Calibrations:
    """The calibration services by robot.

    Args:
        settings: Names.
        bridge: Runs calls on the ROS thread.
    """

    def __init__(self, settings: Settings, bridge: Bridge) -> None:
        self._resolve = partial(settings.resolve, SERVICE)
        self._bridge = bridge
        self._ports: dict[str, CalibrationPort] = {}

    def _port(self, namespace: str) -> CalibrationPort:
        if namespace not in self._ports:
            self._ports[namespace] = CalibrationPort(self._bridge, self._resolve(namespace))
        return self._ports[namespace]

    async def document(self, namespace: str) -> dict[str, Any]:
        """Return whether a robot's dock can be calibrated, as `GET /calibration` shows it.

        Raises:
            Unavailable: `ros_unavailable`.
        """
        port = self._port(namespace)
        return {"available": await port.is_offered(), "service": port.service}

    async def calibrate(self, namespace: str) -> dict[str, Any]:
        """Calibrate the dock that a robot stands on; return the new and the previous values.

        Raises:
            Conflict: The server refuses (`calibration_refused`).
            ServerTimeout: It did not answer (`calibration_timeout`).
            NotInstalled: It does not calibrate (`calibration_unavailable`).
            Unavailable: `ros_unavailable`.
        """
        port = self._port(namespace)
        if not await port.is_offered():
            raise NotInstalled(
                f"there is no service {port.service}: a docking server with the controller dock_pose offers it",
                code="calibration_unavailable",
            )
        try:
            done, text = await port.calibrate()
        except TimeoutError:
            raise ServerTimeout(
                "the docking server did not answer; it may have set its parameters", code="calibration_timeout"
            ) from None
        if not done:
            raise Conflict(text or "the docking server refused, without a reason", code="calibration_refused")
        return {
            "parameters": [
                {"name": name, "value": float(value), "before": float(before)}
                for name, value, before in PARAMETER.findall(text)
            ],
            "yaml": text,
        }
