"""Parameter files of nav2's docking server, with our servers."""

import math
from pathlib import Path

import pytest
from rcl_interfaces.srv import GetParameters
from rclpy.parameter import parameter_value_to_python

from docking.core.geometry import Pose, normalize_angle
from docking.simulation.dock import DOCKED
from tests.support.docking import FAST, SERVER, SUCCEEDED, UNMEASURED, docking_servers, send_dock_goal, send_undock_goal
from tests.support.observer import Observer
from tests.support.processes import ForkedProcess, ros_environment
from tests.support.simulator import dock_simulator
from tests.support.site import look_at
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

UNDOCK_SERVER = "/disconnect_from_charging_dock_action_server"
BACKED = DOCKED.compose(Pose(theta=math.pi))

# As nav2's own example has it, with a marker whose x axis points into the dock.
FILE = """
docking_server:
  ros__parameters:
    controller_frequency: 50.0
    initial_perception_timeout: 20.0
    wait_charge_timeout: 5.0
    dock_approach_timeout: 30.0
    undock_linear_tolerance: 0.05
    undock_angular_tolerance: 0.1
    max_retries: 3
    base_frame: "base_link"
    fixed_frame: "odom"
    DIRECTION
    dock_prestaging_tolerance: 0.5
    dock_plugins: ['simple_charging_dock']
    simple_charging_dock:
      plugin: 'opennav_docking::SimpleChargingDock'
      docking_threshold: 0.05
      staging_x_offset: -0.6
      use_external_detection_pose: true
      use_battery_status: true
      use_stall_detection: false
      external_detection_timeout: 1.0
      external_detection_translation_x: -0.2
      external_detection_translation_y: 0.0
      external_detection_rotation_roll: 0.0
      external_detection_rotation_pitch: 0.0
      external_detection_rotation_yaw: 0.0
      filter_coef: 0.1
      charging_threshold: 0.4
    docks: ['home_dock']
    home_dock:
      type: 'simple_charging_dock'
      frame: map
      pose: [0.0, 0.0, 0.0]
      tolerance: 0.5
    controller:
      k_phi: 3.0
      k_delta: 2.0
      v_linear_min: 0.05
      v_linear_max: 0.15
      use_collision_detection: true
      costmap_topic: "local_costmap/costmap_raw"
      footprint_topic: "local_costmap/published_footprint"
      transform_tolerance: 0.1
      projection_time: 5.0
      simulation_step: 0.1
      dock_collision_threshold: 0.3
amcl:
  ros__parameters:
    alpha1: 0.2
"""
WITHOUT_EFFECT = [
    "undock_linear_tolerance",
    "undock_angular_tolerance",
    "dock_prestaging_tolerance",
    "simple_charging_dock.filter_coef",
    "home_dock.tolerance",
    "controller.costmap_topic",
    "controller.footprint_topic",
    "controller.transform_tolerance",
    "controller.simulation_step",
]


def write(folder: Path, text: str) -> Path:
    path = folder / "nav2_params.yaml"
    path.write_text(text)
    return path


def read(observer: Observer, node: str, *names: str) -> list[object]:
    """The values of parameters."""
    request = GetParameters.Request(names=list(names))
    answer = observer.request(GetParameters, f"{node}/get_parameters", request)
    return [parameter_value_to_python(value) for value in answer.values]


@pytest.mark.parametrize("direction", ["dock_backwards: false", "dock_backwards: true"])
def test_a_robot_docks_as_a_file_of_nav2_says(domain: int, observer: Observer, tmp_path: Path, direction: str) -> None:
    backwards = direction.endswith("true")
    file = write(tmp_path, FILE.replace("DIRECTION", direction))
    rear = ("contact_at_back:=true", "marker_camera_yaw:=3.1416") if backwards else ()
    start = ("start_x:=-1.2", "start_y:=0.1", f"start_theta:={3.14 if backwards else 0.0}")
    with dock_simulator(domain, FAST, *start, *rear), docking_servers(domain, UNMEASURED, file=file):
        site = look_at(observer)
        assert send_dock_goal(observer, dock="home_dock").result(120.0).status == SUCCEEDED
        site.expect_standstill()
        assert site.controls.status["docked"] == "true"
        target = BACKED if backwards else DOCKED
        assert site.pose.distance_to(target) < 0.03
        assert abs(normalize_angle(site.pose.theta - target.theta)) < math.radians(6.0)
        assert max(abs(message.linear.x) for message in site.wheels.messages) <= 0.15 + 1e-9

        assert send_undock_goal(observer).result().status == SUCCEEDED
        assert site.pose.distance_to(target) == pytest.approx(0.6, abs=0.1)


def test_what_a_file_of_nav2_says_is_what_the_servers_have(domain: int, observer: Observer, tmp_path: Path) -> None:
    kind = "simple_charging_dock"
    expected = {
        "controller": "dock_pose",
        "controller_frequency": 50.0,
        "v_linear_min": 0.05,
        "v_linear_max": 0.15,
        "use_collision_detection": True,
        "projection_time": 5.0,
        "dock_direction": "backward",
        "docks": ["home_dock"],
        f"{kind}.staging_x_offset": -0.6,
        f"{kind}.dock_direction": "backward",
        f"{kind}.external_detection_timeout": 1.0,
        f"{kind}.charging_source": "current",
        f"{kind}.charging_threshold": 0.4,
    }
    undocking = {
        "v_linear_max": 0.15,
        "staging_x_offset": -0.6,
        "dock_direction": "backward",
        "charging_source": "current",
        "charging_threshold": 0.4,
    }
    file = write(tmp_path, FILE.replace("DIRECTION", "dock_backwards: true"))
    with docking_servers(domain, file=file):
        assert read(observer, SERVER, *expected) == [*expected.values()]
        assert read(observer, UNDOCK_SERVER, *undocking) == [*undocking.values()]


def test_each_parameter_that_has_no_effect_is_told_once(domain: int, observer: Observer, tmp_path: Path) -> None:
    file = write(tmp_path, FILE.replace("DIRECTION", "dock_backwards: false"))
    arguments = ("--params-file", str(file), "-p", "max_retrys:=2", "-p", "controller:=dock_pose")
    with ForkedProcess("docking_server", "--ros-args", *arguments, env=ros_environment(domain)) as server:
        wait_until(lambda: "battery_state_subscriber" in observer.node.get_node_names(), "the nodes")
        server.wait_for("amcl")
        warnings = [line for line in server.own_lines if "[WARN]" in line]
        for name in WITHOUT_EFFECT:
            assert sum(f"{file}: {name} has no effect" in line for line in warnings) == 1, name
        told = " ".join(warnings)
        assert "max_retrys has no effect" in told
        assert "Did you mean max_retries?" in told
        assert f"{file}: parameters of /amcl have no effect" in told
        assert len(warnings) == len(WITHOUT_EFFECT) + 2


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("controller.v_linear_max: 9.0", "controller.v_linear_max is 9.0, but must be from 0.01 to 2 m/s"),
        ("controller.v_linear_max: 1", "controller.v_linear_max is 1, but must be a double, with a decimal point"),
        ("max_retries: 1.5", "max_retries is 1.5, but must be an integer"),
        ("base_frame: chassis", "base_frame is 'chassis', which is not possible here. "),
        ("odom_topic: odometry/filtered", "Odometry is heard on `odom`: remap it, by `-r odom:=<topic>`."),
        ("dock_backwards: 1", "dock_backwards is 1, but must be true or false"),
        (
            "{controller: dock_pose, use_external_detection_pose: false, charging_source: pose}",
            "charging_source is 'pose', but with use_external_detection_pose false the pose is known",
        ),
        ("{dock_plugins: [a], a: {plugin: 'my::Dock'}}", "a.plugin is 'my::Dock', which is not possible here. "),
        (
            "{dock_backwards: true, dock_plugins: [a], a: {dock_direction: forward}}",
            "dock_backwards is true, but a.dock_direction is 'forward'. Leave dock_backwards out",
        ),
        (
            "{controller: rotate, dock_plugins: [a], a: {use_battery_status: false}}",
            "a.charging_source is 'pose', but the controller rotate knows no docked pose",
        ),
    ],
)
def test_what_would_move_the_robot_otherwise_is_refused(domain: int, tmp_path: Path, line: str, told: str) -> None:
    values = line if line.startswith("{") else f"{{{line}}}"
    file = write(tmp_path, f"docking_server: {{ros__parameters: {values}}}\n")
    with ForkedProcess(
        "docking_server", "--ros-args", "--params-file", str(file), env=ros_environment(domain)
    ) as server:
        assert server.wait() == 2
        assert told in server.own_lines[-1]
        assert len(server.own_lines) == 1


@pytest.mark.parametrize(
    ("program", "arguments", "told"),
    [
        ("dock_simulator", ("-p", "start_xx:=1.0"), "start_xx has no effect: /dock_simulator has no such parameter"),
        (
            "dock_simulator",
            ("-p", "qos_overrides.odom.publisher.depth:=1"),
            "the form is qos_overrides./name/",
        ),
        ("dock_simulator", ("-p", "docking_servr:a:=1"), "parameters of /docking_servr have no effect"),
        ("fibonacci_action_server", ("-p", "step_periode:=1.0"), "Did you mean step_period?"),
        ("fibonacci_action_client", ("-p", "order:=3"), "order has no effect"),
        ("connect_to_charging_dock_client", ("-p", "voltage:=3.0"), "voltage has no effect"),
        ("connect_to_charging_dock_server", ("-p", "docking_servr:a:=1"), "Did you mean docking_server?"),
        (
            "docking_server",
            ("-p", "controller:=dock_pose", "-p", "connect_to_charging_dock_action_server:dock_direction:=backward"),
            "until a goal has docked it, it undocks as if it had docked forward",
        ),
        ("docking_server", ("--params-file", "/dev/fd/0"), "/dev/fd/0: parameters in it without effect are not listed"),
        ("docking_server", ("-p", "battery_state_subscriber:x:=1"), "/battery_state_subscriber has no such parameter"),
        (
            "docking_server",
            ("-r", "__ns:=/robot1", "-p", "docking_server:controller.v_linear_max:=0.1"),
            "parameters of /docking_server have no effect. The nodes of this program are /robot1/connect_to",
        ),
    ],
)
def test_every_program_tells_what_has_no_effect(
    domain: int, program: str, arguments: tuple[str, ...], told: str
) -> None:
    with ForkedProcess(program, "--ros-args", *arguments, env=ros_environment(domain)) as process:
        process.wait_for(told)


def test_a_key_that_comes_twice_is_refused(domain: int, tmp_path: Path) -> None:
    file = write(tmp_path, "docking_server:\n  ros__parameters:\n    max_retries: 1\n    max_retries: 2\n")
    with ForkedProcess(
        "docking_server", "--ros-args", "--params-file", str(file), env=ros_environment(domain)
    ) as server:
        assert server.wait() == 2
        assert server.own_lines == [f"error: --params-file: {file} has the key 'max_retries' twice"]


@pytest.mark.parametrize(("program", "file"), [("docking_server", "docking_server"), ("dock_simulator",) * 2])
def test_our_own_files_have_nothing_without_effect(domain: int, observer: Observer, program: str, file: str) -> None:
    path = Path(__file__).parents[2] / "backend/action_tutorials_py/config" / f"{file}.yaml"
    with ForkedProcess(program, "--ros-args", "--params-file", str(path), env=ros_environment(domain)) as process:
        last = {"docking_server": "battery_state_subscriber"}.get(program, program)
        wait_until(lambda: last in observer.node.get_node_names(), "the nodes")
        if program == "docking_server":
            assert send_dock_goal(observer).accepted
        assert "[WARN]" not in process.output


NAMESPACED = """
/**/docking_server:
  ros__parameters: {controller: {v_linear_max: 0.1, k_phi: 2.5}}
robot1:
  docking_server:
    ros__parameters: {max_retries: 1}
  connect_to_charging_dock_action_server:
    ros__parameters: {v_linear_max: 0.2, controller: dock_pose}
/robot2/docking_server:
  ros__parameters: {max_retries: 2}
"""


def test_sections_are_found_by_namespace_and_those_of_our_own_nodes_count_more(
    domain: int, observer: Observer, tmp_path: Path
) -> None:
    file = write(tmp_path, NAMESPACED)
    arguments = ("-r", "__ns:=/robot1", "--params-file", str(file))
    with ForkedProcess("docking_server", "--ros-args", *arguments, env=ros_environment(domain)) as server:
        names = ("v_linear_max", "k_phi", "max_retries")
        assert read(observer, f"/robot1{SERVER}", *names) == [0.2, 2.5, 1]
        assert read(observer, f"/robot1{UNDOCK_SERVER}", "v_linear_max") == [0.1]
        assert f"{file}: controller.v_linear_max has no effect, since v_linear_max is 0.2" in server.output
        assert "robot2" not in server.output


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("v_linear_max", math.nan, "v_linear_max out of range"),
        ("v_linear_max", math.inf, "v_linear_max out of range"),
        ("v_linear_max", 9.0, "v_linear_max out of range"),
        ("v_linear_max", 1, "expected 'Type.DOUBLE' got 'Type.INTEGER'"),
        ("max_retries", 2.0, "expected 'Type.INTEGER' got 'Type.DOUBLE'"),
        ("controller.v_linear_max", 0.1, "undeclared parameter"),
        (
            "near.charging_source",
            "pos",
            "near.charging_source is 'pos', but must be one of: status, current, pose, none",
        ),
        ("near.docking_threshold", math.nan, "near.docking_threshold out of range"),
    ],
)
def test_what_cannot_be_set_at_run_time_is_refused_with_the_reason(
    domain: int, observer: Observer, name: str, value: object, reason: str
) -> None:
    with docking_servers(domain, "dock_plugins:=[near]"):
        assert reason in observer.set_parameter(SERVER, name, value)
