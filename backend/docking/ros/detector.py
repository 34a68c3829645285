"""Calls the service that switches what detects the marker on and off."""

from typing import Any

from rclpy.client import Client
from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from docking.core.errors import FailedToDetectDock
from docking.goal.detector import Detector
from docking.parameters import DetectorSettings

TYPES: dict[str, Any] = {"std_srvs/srv/SetBool": SetBool, "std_srvs/srv/Trigger": Trigger}


class DetectorClient:
    """The client of one goal's service at a time. All calls must come from the thread that spins the node."""

    def __init__(self, node: Node) -> None:
        """Start without a client.

        Args:
            node: The node that calls.
        """
        self._node = node
        self._name = ""
        self._clients: dict[str, tuple[Client, Any]] = {}
        self._call: Any = None

    @property
    def name(self) -> str:
        """Of the service, with its namespace."""
        return self._name

    def detector(self, settings: DetectorSettings) -> Detector | None:
        """Return the detector that a new goal waits for; None where no service is named.

        Args:
            settings: The name of the service, and how long to wait for it.
        """
        if not settings.detector_service_name:
            return None
        self._name = str(self._node.resolve_service_name(settings.detector_service_name))
        return Detector(self, settings.detector_service_timeout)

    def switch_on(self) -> bool:
        """See `DetectorService`."""
        if self._call is None and (found := self._find()) is not None:
            client, kind = found
            self._call = client.call_async(_request(kind, on=True))
        return self._call is not None

    def answer(self) -> str | None:
        """See `DetectorService`."""
        return _answer(self._call)

    def end(self) -> None:
        """The goal is over: switch the detector off, where it was asked to be on. Nothing waits for the answer."""
        name, call, self._name, self._call = self._name, self._call, "", None
        if call is None:
            return
        client, kind = self._clients[name]
        if not call.done():
            client.remove_pending_request(call)

        def log(answered: Any) -> None:
            if reason := _answer(answered):
                self._node.get_logger().warning(f"The detector's service {name} did not switch it off: {reason}")

        client.call_async(_request(kind, on=False)).add_done_callback(log)

    def _find(self) -> tuple[Client, Any] | None:
        """The client, once there is such a service.

        Raises:
            FailedToDetectDock: It is of another type.
        """
        if self._name not in self._clients:
            types = dict(self._node.get_service_names_and_types()).get(self._name, ())
            if not types:
                return None
            kind = next((TYPES[one] for one in types if one in TYPES), None)
            if kind is None:
                raise FailedToDetectDock(
                    f"the detector's service {self._name} is of the type {types[0]}, but must be {' or '.join(TYPES)}"
                )
            self._clients[self._name] = self._node.create_client(kind, self._name), kind
        found = self._clients[self._name]
        return found if found[0].service_is_ready() else None


def _request(kind: Any, *, on: bool) -> Any:
    return SetBool.Request(data=on) if kind is SetBool else Trigger.Request()


def _answer(call: Any) -> str | None:
    """Return why a call was refused, empty where it was not; None before it was answered."""
    if call is None or not call.done():
        return None
    if call.exception() is not None:
        return str(call.exception())
    response = call.result()
    return "" if response.success else response.message or "it gave no reason"
