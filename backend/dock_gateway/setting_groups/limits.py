"""The settings that limit what clients and ROS nodes can take."""

from typing import Annotated, ClassVar

from pydantic import Field

from dock_gateway.setting_groups.group import SettingsGroup
from dock_gateway.setting_types import TUNING, Seconds


class LimitSettings(SettingsGroup):
    """The settings that limit what clients and ROS nodes can take."""

    group: ClassVar[str] = "Limits"

    max_message_bytes: int = Field(
        1_000_000,
        ge=1024,
        description="Maximum size of a ROS message, in bytes. Larger feedback is dropped (`feedback_dropped`); a "
        "goal with a larger result ends without it (`result_too_large`).",
    )
    max_connections: int = Field(
        4000,
        ge=32,
        description="Maximum number of connections; lower if the limit of open files does not leave 128 for other "
        "files.",
    )
    max_connections_per_address: int = Field(
        2000,
        ge=8,
        description="Maximum number of connections from one address. Behind a proxy, all clients have its address.",
    )
    max_streams_per_user: int = Field(
        250, ge=1, description="Maximum number of streams of one user (429), with `authentication`."
    )
    max_goals_per_minute: int = Field(
        600, ge=1, description="Maximum number of goals of one user in a minute (429), with `authentication`."
    )
    max_actions: Annotated[int, TUNING] = Field(
        1000,
        ge=2,
        description="Maximum number of actions on the ROS graph that the gateway serves, docking first. Each takes "
        "0.7 MB of memory.",
    )
    max_robots: Annotated[int, TUNING] = Field(
        500, ge=1, description="Maximum number of robots that the gateway serves."
    )
    max_body_bytes: Annotated[int, TUNING] = Field(
        1_000_000, ge=1024, description="Maximum size of a request body, in bytes (413)."
    )
    body_timeout: Annotated[Seconds, TUNING] = Field(
        10.0, description="Seconds that a client may take to send a body (408)."
    )
    max_header_bytes: Annotated[int, TUNING] = Field(
        65_536,
        ge=8192,
        le=1_000_000,
        description="Maximum size of a request's first line and headers together, in bytes (431).",
    )
    header_timeout: Annotated[Seconds, TUNING] = Field(
        10.0, description="Seconds that a client may take to send the first line and headers of a request (408)."
    )
    max_frames_per_second: Annotated[int, TUNING] = Field(
        1000,
        ge=10,
        description="Maximum number of frames per second on a WebSocket, including pings. Beyond it, the WebSocket "
        "is closed with 1008.",
    )
    max_frame_bytes_per_second: Annotated[int, TUNING] = Field(
        4_000_000,
        ge=65_536,
        description="Maximum number of bytes per second on a WebSocket. Beyond it, the WebSocket is closed with 1008.",
    )
    max_pending_goals: Annotated[int, TUNING] = Field(
        32,
        ge=1,
        description="Maximum number of goals of one action that wait for acceptance (429): "
        "[shares](configuration.md#shares-of-users).",
    )
    max_subscribers: Annotated[int, TUNING] = Field(
        1000,
        ge=1,
        description="Maximum number of streams of all users together (429): "
        "[shares](configuration.md#shares-of-users).",
    )
    max_exports_per_user: Annotated[int, TUNING] = Field(
        2, ge=1, description="Maximum number of simultaneous exports of one user (429), with `authentication`."
    )
    subscriber_queue: Annotated[int, TUNING] = Field(
        256,
        ge=1,
        description="Maximum number of feedback events that wait for a slow subscriber. Beyond it, the oldest are "
        "dropped.",
    )
    subscriber_timeout: Annotated[Seconds, TUNING] = Field(
        30.0, description="Seconds after which a subscriber that does not read is disconnected."
    )
    heartbeat_interval: Annotated[Seconds, TUNING] = Field(5.0, description="Seconds between heartbeats on a stream.")
