"""The settings of rosbridge's door."""

from typing import Annotated, ClassVar

from pydantic import Field

from dock_gateway.setting_types import ListensOn
from dock_gateway.settings import ExtensionSettings


class RosbridgeSettings(ExtensionSettings):
    """A port of its own, as clients expect it."""

    group: ClassVar[str] = "rosbridge"

    rosbridge_port: Annotated[int | None, ListensOn("/rosbridge")] = Field(
        None,
        ge=1,
        le=65535,
        description="A further port, on which WebSockets of `/` are `/rosbridge`, such as 9090: "
        "[rosbridge.md](extensions/rosbridge.md).",
    )
