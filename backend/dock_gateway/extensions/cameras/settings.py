"""The settings of cameras."""

from typing import Annotated, ClassVar

from pydantic import Field

from dock_gateway.setting_types import TUNING
from dock_gateway.settings import ExtensionSettings


class CameraSettings(ExtensionSettings):
    """Limits of pictures."""

    group: ClassVar[str] = "Cameras"

    camera_max_rate: float = Field(
        10.0, ge=0.1, le=60, description="Pictures per second of a camera that a viewer gets at most."
    )
    camera_max_width: int = Field(
        1280,
        ge=16,
        le=8192,
        description="Width in pixels above which pictures of cameras are scaled down: "
        "[cameras.md](extensions/cameras.md).",
    )
    camera_quality: Annotated[int, TUNING] = Field(
        75, ge=10, le=95, description="Quality of the JPEG pictures that the gateway encodes itself, 10 to 95."
    )
