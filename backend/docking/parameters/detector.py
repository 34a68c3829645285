"""The program that detects the dock's marker, where it is to run only while a goal needs it."""

import re
from dataclasses import dataclass

from docking.core.parameter import number, string

SERVICE = re.compile(r"/?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*")


def _read_service(name: str) -> None:
    if name and not SERVICE.fullmatch(name):
        raise ValueError(f"is {name!r}, which is no name of a service")


@dataclass(frozen=True, slots=True)
class DetectorSettings:
    """Parameters that switch the detector on for a goal and off after it; the names are nav2's."""

    detector_service_name: str = string(
        "",
        "service",
        "Service that switches on what detects the marker before the dock is looked for, and off when the goal ends: "
        "std_srvs/srv/SetBool, or std_srvs/srv/Trigger, which is called for both. If it is empty, none is called.",
        _read_service,
    )
    detector_service_timeout: float = number(
        5.0, 0.1, 60.0, "s", "Time for which the robot waits for that service; then the goal is aborted."
    )
