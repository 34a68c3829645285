"""The settings of robots: their names on the ROS graph, and how they are watched."""

from typing import Annotated, ClassVar, Self

from pydantic import Field, model_validator

from dock_gateway.setting_groups.group import SettingsGroup
from dock_gateway.setting_groups.one_robot import RobotTables
from dock_gateway.setting_types import (
    TUNING,
    ActionType,
    Namespace,
    NodeName,
    OptionalTopic,
    Robots,
    Seconds,
    Topic,
    Topics,
)


class RobotSettings(SettingsGroup):
    """The settings of robots: their names on the ROS graph, and how they are watched."""

    group: ClassVar[str] = "Robots"

    node_name: NodeName = Field("dock_gateway", description="Name of the gateway's ROS node.")
    namespace: Namespace = Field("", description="ROS namespace of the robot, such as `/robot1`.")
    serve_robots: Robots = Field(
        (),
        description="Robots that this gateway serves: namespaces such as `/robot1` or `/fleet_a/*`, separated by "
        "commas. Empty: every robot. Other gateways serve the others: [postgresql.md](postgresql.md#shares).",
    )
    dock_action: OptionalTopic = Field(
        "",
        description="The action behind `/dock`, relative to the namespace. Empty: picked for each robot from the ROS "
        "graph ([nav2.md](nav2.md)).",
    )
    dock_action_type: ActionType = Field("", description="The type of that action. Empty: as on the ROS graph.")
    undock_action: OptionalTopic = Field(
        "", description="The action behind `/undock`, relative to the namespace. Empty: as for `DOCK_ACTION`."
    )
    undock_action_type: ActionType = Field("", description="The type of that action. Empty: as on the ROS graph.")
    robots: RobotTables = Field(
        {},
        description="What single robots have of their own, by namespace or pattern: tables of the configuration "
        "file, or JSON ([below](configuration.md#single-robots)).",
    )
    default_dock: str = Field(
        "",
        max_length=200,
        description="The dock that a `POST /dock` without `dock_id` means, for action servers that know docks by name "
        "([nav2.md](nav2.md)).",
    )
    battery_topic: Topic = Field("battery_status", description="Topic of `sensor_msgs/BatteryState`.")
    low_battery: float = Field(
        0.2,
        ge=0,
        lt=1,
        description="Charge (0 to 1) below which a robot that is not charging raises an alert; 0: never.",
    )
    battery_stale_after: Seconds = Field(
        2.0, description="Seconds without a message after which the battery state is stale."
    )
    cmd_vel_topic: Topic = Field(
        "cmd_vel",
        description="Topic of `geometry_msgs/Twist` or `TwistStamped`, whichever the robot's base subscribes to. "
        "`/stop` publishes zero velocity on it.",
    )
    command_timeout: float = Field(
        0.3,
        ge=0,
        le=60,
        description="Seconds without a command after which a robot that moves for a docking goal gets zero velocity: "
        "[stop.md](stop.md#commands-that-end). 0: never.",
    )
    stop_state_topic: Topic = Field("stop_latched", description="Topic of `std_msgs/Bool`: whether a stop is latched.")
    emergency_stop_topics: Topics = Field(
        (),
        description="More topics of `std_msgs/Bool`, separated by commas, such as that of an emergency stop: `true` on "
        "one of them stops the robot.",
    )
    diagnostics_topic: Topic = Field(
        "/diagnostics",
        description="Topic of `diagnostic_msgs/DiagnosticArray`, on which action servers report why a goal ended.",
    )
    allow_duplicate_servers: bool = Field(
        False,
        description="Whether goals are sent to an action that has more than one server. Each of them executes every "
        "goal.",
    )
    allow_shared_servers: bool = Field(
        False,
        description="Whether a node that serves the docking actions of several robots docks different robots. If not, "
        "they count as one robot by several names: automatic docking sends it no goals.",
    )
    forget_robot_after: float = Field(
        600.0,
        ge=0,
        description="Seconds after which a robot that has left the ROS graph is removed from `/robots`; 0: never. "
        "The configured robot is never removed.",
    )
    store_poses: bool = Field(
        True,
        description="Whether to store where a robot is while a goal on one of its actions runs, for the map of the "
        "goal's replay.",
    )
    server_wait: Annotated[Seconds, TUNING] = Field(
        1.5, description="Seconds to wait for an action server to appear before a goal is refused (503)."
    )
    accept_timeout: Annotated[Seconds, TUNING] = Field(
        5.0, description="Seconds that an action server may take to accept or reject a goal (504)."
    )
    cancel_timeout: Annotated[Seconds, TUNING] = Field(
        5.0, description="Seconds that an action server may take to answer a cancel request (504)."
    )
    ping_interval: Annotated[Seconds, TUNING] = Field(
        1.0, description="Seconds between two checks of an action server that answers."
    )
    stalled_after: Annotated[Seconds, TUNING] = Field(
        3.0, description="Seconds without a message from the action server after which a running goal is `stalled`."
    )
    lost_after: Annotated[Seconds, TUNING] = Field(
        8.0, description="Seconds without a message from the action server after which a running goal is `lost`."
    )

    @model_validator(mode="after")
    def _check_times(self) -> Self:
        if self.stalled_after <= self.ping_interval:
            raise ValueError("ping_interval must be shorter than stalled_after")
        if self.lost_after <= self.stalled_after:
            raise ValueError("lost_after must be longer than stalled_after")
        return self
