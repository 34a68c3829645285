"""Has the program that detects the marker switched on before the dock is looked for. No ROS."""

from typing import Protocol

from docking.core.errors import FailedToDetectDock


class DetectorService(Protocol):
    """The service that switches the detector.

    Attributes:
        name: Of the service.
    """

    @property
    def name(self) -> str: ...  # noqa: D102 - see above

    def switch_on(self) -> bool:
        """Ask for it, unless that was done; False while there is no such service.

        Raises:
            FailedToDetectDock: The service is of a type that cannot be called.
        """

    def answer(self) -> str | None:
        """The reason why it refused, empty where the detector is on; None before it has answered."""


class Detector:
    """Waits, for a while, until the detector is on.

    Attributes:
        timeout: The longest that it waits, in s.
    """

    def __init__(self, service: DetectorService, timeout: float) -> None:
        """Ask for nothing yet.

        Args:
            service: The service.
            timeout: How long to wait for it, in s.
        """
        self._service = service
        self.timeout = timeout
        self._waited = 0.0

    def is_on(self, dt: float) -> bool:
        """Let time pass, and say whether the detector is on.

        Args:
            dt: Seconds since the last call.

        Raises:
            FailedToDetectDock: The service is missing, hangs or refuses.
        """
        called, name = self._service.switch_on(), f"the detector's service {self._service.name}"
        answer = self._service.answer() if called else None
        if answer == "":
            return True
        if answer is not None:
            raise FailedToDetectDock(f"{name} did not switch it on: {answer}")
        self._waited += dt
        if self._waited > self.timeout:
            what = "did not answer" if called else "was not there"
            raise FailedToDetectDock(f"{name} {what} for {self.timeout:g} s (detector_service_timeout)")
        return False
