"""The settings of shared docks."""

from pathlib import Path
from typing import ClassVar, Literal

from pydantic import Field

from dock_gateway.settings import ExtensionSettings


class ChargerSettings(ExtensionSettings):
    """The settings of shared docks: who waits first, when a dock is out of order, and where servers read them."""

    group: ClassVar[str] = "Shared docks"

    chargers_queue: Literal["longest_waiting", "lowest_charge"] = Field(
        "longest_waiting",
        description="Which robot gets a [shared dock](extensions/chargers.md) first that is free again. A robot that "
        "has waited for 30 minutes comes first in any case.",
    )
    chargers_failures: int = Field(
        3, ge=0, le=100, description="Failed dockings in a row after which a shared dock is out of order; 0: never."
    )
    chargers_file: Path | None = Field(
        None,
        description="File in which the gateway keeps the shared docks that have a pose, for the docking servers whose "
        "`dock_database` it is. Empty: none.",
    )
