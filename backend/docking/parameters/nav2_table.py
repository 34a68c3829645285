"""The parameters of nav2's docking server (opennav_docking of Jazzy, Kilted and later), and what they mean here."""

import enum
from dataclasses import dataclass

from docking.core.parameter import Value

TYPE, DOCK, CONTROLLER = "<type>.", "<dock>.", "controller."
"""What stands before the names of parameters of a type of docks, of a dock, of the controller."""


class Meaning(enum.Enum):
    """The treatment of a parameter of nav2."""

    SAME = "the same"
    """There is one of that name here."""
    MAPPED = "sets"
    """It sets one of another name."""
    REFUSED = "refused"
    """Unless it has a value that says what happens here, the program ends: the robot would move otherwise."""
    IGNORED = "ignored"
    """It has no effect here, which a warning says, unless it has a value that says what happens here."""


@dataclass(frozen=True)
class Nav2Parameter:
    """A parameter of nav2.

    Attributes:
        name: As nav2 writes it, with `<type>.` or `<dock>.` for the name of a type or of a dock.
        default: Of nav2; None if there is none.
        meaning: What becomes of it.
        ours: What it sets here.
        text: More about that, for the documentation; why it is ignored or refused, and what to do, as a sentence.
        accepted: Values that say what happens here anyway.
        differs: Whether the robot may move otherwise where it is not given, because the default here is another one.
    """

    name: str
    default: Value | None
    meaning: Meaning
    ours: str = ""
    text: str = ""
    accepted: tuple[Value, ...] = ()
    differs: str = ""


def _same(default: Value | None, *names: str, text: str = "") -> tuple[Nav2Parameter, ...]:
    return tuple(Nav2Parameter(name, default, Meaning.SAME, text=text) for name in names)


def _mapped(name: str, default: Value | None, ours: str = "", text: str = "", differs: str = "") -> Nav2Parameter:
    return Nav2Parameter(name, default, Meaning.MAPPED, ours or name.rpartition(".")[2], text, differs=differs)


def _refused(
    name: str, default: Value | None, accepted: tuple[Value, ...], text: str, differs: str = ""
) -> Nav2Parameter:
    return Nav2Parameter(name, default, Meaning.REFUSED, text=text, accepted=accepted, differs=differs)


def _ignored(name: str, default: Value | None, text: str, *accepted: Value) -> Nav2Parameter:
    return Nav2Parameter(name, default, Meaning.IGNORED, text=text, accepted=accepted)


CHARGING_DOCK, NON_CHARGING_DOCK = "opennav_docking::SimpleChargingDock", "opennav_docking::SimpleNonChargingDock"
OBSTACLES = "Obstacles are seen by a laser scanner, on `scan`."
UNDOCKED = "A robot has left its dock when it has backed out by `-staging_x_offset`."

NAV2: tuple[Nav2Parameter, ...] = (
    # Of the server.
    *_same(50.0, "controller_frequency"),
    *_same(5.0, "initial_perception_timeout"),
    *_same(5.0, "wait_charge_timeout"),
    *_same(30.0, "dock_approach_timeout"),
    *_same(3, "max_retries"),
    *_same(0.5, "dock_prestaging_tolerance", text="it counts with `navigate_to_staging_pose`"),
    *_same("", "navigator_bt_xml", text="it counts with `navigate_to_staging_pose`"),
    *_same(False, "enable_stamped_cmd_vel", text="here the default is `auto`"),
    *_same(None, "dock_plugins", "docks", "dock_database"),
    _mapped("dock_backwards", False, "dock_direction", "for all types: `backward` or `forward`"),
    _refused(
        "base_frame",
        "base_link",
        ("base_link", "base_footprint"),
        "Docking is for the frame whose pose odometry tells, its `child_frame_id`. If that is this frame, leave "
        "base_frame out; if not, publish odometry of it.",
    ),
    _ignored("fixed_frame", "odom", "Docking goes by the frame of odometry, its `frame_id`.", "odom"),
    _refused("odom_topic", "odom", ("odom",), "Odometry is heard on `odom`: remap it, by `-r odom:=<topic>`."),
    _ignored("odom_duration", 0.3, "Velocities are measured from the poses of odometry."),
    _ignored("rotate_to_dock_timeout", 10.0, "The turn at the staging pose counts into dock_approach_timeout."),
    _ignored("rotation_angular_tolerance", 0.05, "The turn at the staging pose ends within 1.5°."),
    _ignored("undock_linear_tolerance", 0.05, UNDOCKED),
    _ignored("undock_angular_tolerance", 0.05, UNDOCKED),
    _ignored("action_server_result_timeout", 10.0, "A result can be fetched for 10 s."),
    _ignored("introspection_mode", "disabled", "Actions and services are not introspected.", "disabled"),
    _ignored("service_introspection_mode", "disabled", "Services are not introspected.", "disabled"),
    _ignored("bond_heartbeat_period", 0.1, "There is no bond with the lifecycle manager."),
    # Of the controller.
    _mapped("controller.k_phi", 3.0),
    _mapped("controller.k_delta", 2.0),
    _mapped("controller.beta", 0.4),
    _mapped("controller.lambda", 2.0),
    _mapped("controller.v_linear_min", 0.1),
    _mapped("controller.v_linear_max", 0.25),
    _mapped("controller.v_angular_max", 0.75),
    _mapped("controller.slowdown_radius", 0.25, text="here all of that way is driven at `v_linear_min`"),
    _ignored("controller.deceleration_max", 2.5, "a_linear_max limits it."),
    _mapped("controller.rotate_to_heading_angular_vel", 1.0, "v_angular_max", "where it is the lower one of both"),
    _mapped("controller.rotate_to_heading_max_angular_accel", 3.2, "a_angular_max"),
    _mapped(
        "controller.use_collision_detection",
        True,
        text="here with a laser scanner (`scan`) instead of a costmap",
        differs="false",
    ),
    _ignored("controller.costmap_topic", "local_costmap/costmap_raw", OBSTACLES),
    _ignored("controller.footprint_topic", "local_costmap/published_footprint", "Set footprint or robot_radius."),
    _ignored("controller.transform_tolerance", 0.1, OBSTACLES),
    _mapped("controller.projection_time", 5.0, text="here the robot slows down from there, and stops at half of it"),
    _ignored("controller.simulation_time_step", 0.1, OBSTACLES),
    _ignored("controller.simulation_step", None, OBSTACLES),
    _mapped("controller.dock_collision_threshold", 0.3),
    # Of a type of docks.
    _refused(
        "<type>.plugin",
        None,
        (CHARGING_DOCK, NON_CHARGING_DOCK),
        "The second one sets `charging_source` of the type: `none`. Other plugins cannot be loaded: leave it out to "
        "dock by the other parameters of this type, or write a controller of your own.",
    ),
    *_same(0.05, "<type>.docking_threshold"),
    *_same(-0.7, "<type>.staging_x_offset"),
    *_same(0.0, "<type>.staging_yaw_offset", text="it counts with `navigate_to_staging_pose`"),
    *_same("forward", "<type>.dock_direction"),
    *_same(False, "<type>.rotate_to_dock"),
    Nav2Parameter(
        "<type>.use_external_detection_pose",
        False,
        Meaning.SAME,
        text="where it is false, the robot feels for the contacts, too",
        differs="true",
    ),
    *_same(1.0, "<type>.external_detection_timeout"),
    *_same(-0.2, "<type>.external_detection_translation_x"),
    *_same(0.0, "<type>.external_detection_translation_y"),
    Nav2Parameter("<type>.external_detection_rotation_roll", -1.57, Meaning.SAME, differs="0"),
    Nav2Parameter("<type>.external_detection_rotation_pitch", 1.57, Meaning.SAME, differs="0"),
    *_same(0.0, "<type>.external_detection_rotation_yaw"),
    _ignored("<type>.filter_coef", 0.1, "Detections are filtered by their noise, which is measured."),
    _mapped("<type>.use_battery_status", True, "<type>.charging_source", "`true`: `current`, `false`: `pose`"),
    *_same(0.5, "<type>.charging_threshold", text="if it is given, `charging_source` of the type is `current`"),
    *_same(False, "<type>.use_stall_detection", text="it counts within `docking_threshold`; odometry tells, too"),
    *_same(None, "<type>.stall_joint_names"),
    *_same(1.0, "<type>.stall_velocity_threshold", "<type>.stall_effort_threshold"),
    *_same("", "<type>.detector_service_name", text="`std_srvs/srv/SetBool` is called, too"),
    *_same(5.0, "<type>.detector_service_timeout"),
    _ignored("<type>.subscribe_toggle", False, "detected_dock_pose is subscribed to while a goal runs.", True, False),
    # Of a dock.
    *_same(None, "<dock>.type"),
    *_same("map", "<dock>.frame"),
    *_same(None, "<dock>.pose"),
    *_same("", "<dock>.id"),
)
