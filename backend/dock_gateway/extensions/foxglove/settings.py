"""The settings of Foxglove's door."""

from typing import Annotated, ClassVar

from pydantic import Field

from dock_gateway.setting_types import ListensOn
from dock_gateway.settings import ExtensionSettings


class FoxgloveSettings(ExtensionSettings):
    """A port of its own, as clients expect it."""

    group: ClassVar[str] = "Foxglove"

    foxglove_port: Annotated[int | None, ListensOn("/foxglove")] = Field(
        None,
        ge=1,
        le=65535,
        description="A further port, on which WebSockets of `/` are `/foxglove`, such as 8765: "
        "[foxglove.md](extensions/foxglove.md).",
    )
