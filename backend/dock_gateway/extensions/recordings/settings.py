"""The settings of recordings."""

from pathlib import Path
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from dock_gateway.setting_types import TUNING, Days, Megabytes, Topics
from dock_gateway.settings import ExtensionSettings


class RecordingSettings(ExtensionSettings):
    """The settings of recordings: what is recorded, and how much of it is kept."""

    group: ClassVar[str] = "Recordings"

    recordings: Literal["all", "failed", "none"] = Field(
        "failed",
        description="Which goals leave a [recording](extensions/recordings.md): `all`, those that did not succeed "
        "(`failed`), or `none`.",
    )
    recording_topics: Topics = Field(
        (),
        description="More topics that are recorded, relative to the namespace of each robot or absolute, separated by "
        "commas: `imu,/map`.",
    )
    recording_buffer_s: float = Field(
        30.0, ge=10, le=600, description="Seconds of each robot's messages that are kept in memory."
    )
    recording_buffer_mb: Annotated[Megabytes, TUNING] = Field(
        8, description="Maximum size of those messages, in megabytes for each robot. The oldest are dropped first."
    )
    recording_buffer_robots: int = Field(
        20,
        ge=0,
        description="Number of robots whose messages are kept in memory all the time. The goals of others are recorded "
        "from their beginning.",
    )
    recordings_path: Path | None = Field(
        None,
        description="Folder of the recordings. Empty: `recordings-<ROS_DOMAIN_ID>` in the user's data directory, or "
        "`recordings-<ROS_DOMAIN_ID>-localhost` if discovery is limited to this machine.",
    )
    recording_retention_mb: Megabytes = Field(
        2000,
        description="Maximum size of all recordings, in megabytes. Those of goals that succeeded are deleted first, "
        "the oldest first.",
    )
    recording_retention_days: Days = Field(30.0, description="Days for which recordings are kept.")
