"""The private parts of rclpy: one module uses them, and says at the start which of them an rclpy lacks."""

import ast
import uuid
from collections.abc import Iterator
from pathlib import Path

import pytest
from rclpy.context import Context
from rclpy.node import Node
from std_msgs.msg import Bool

import robot_io
from docking.ros.process import EXIT_USAGE, ros_context, run_process
from robot_io import rclpy_private
from robot_io.participants import create_context
from robot_io.qos import LATCHED
from robot_io.rclpy_private import UnsupportedRclpyError, require_supported, take_bool
from tests.support.waiting import wait_until

BACKEND = Path(robot_io.__file__).parents[1]
MODULES = sorted(
    module for name in ("robot_io", "docking", "dock_gateway") for module in (BACKEND / name).rglob("*.py")
)
PRIVATE_MODULES = {"ctypes", "rclpy.impl", "rclpy.waitable", "rclpy.handle", "rclpy._rclpy_pybind11"}
PRIVATE_NAMES = {"take_message", "pointer", "WaitSet", "await_or_execute", "rclpy_implementation"}
# Programs end their children with themselves by ctypes, `doctor` asks the clock: neither has to do with ROS.
OTHERS = {name: {"ctypes"} for name in ("dock_gateway/doctor/machine.py", "robot_io/children.py")}


def private_parts(source: str) -> set[str]:
    """What a module uses of rclpy's inside."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found |= {node.module or "", *(alias.name for alias in node.names)}
        elif isinstance(node, ast.Attribute):
            found.add(node.attr)
    modules = {name for name in found if any(f"{name}.".startswith(f"{part}.") for part in PRIVATE_MODULES)}
    return modules | found & PRIVATE_NAMES


@pytest.mark.parametrize("module", MODULES, ids=lambda module: str(module.relative_to(BACKEND)))
def test_only_one_module_uses_private_parts(module: Path) -> None:
    found = private_parts(module.read_text())
    name = str(module.relative_to(BACKEND))
    if name == "robot_io/rclpy_private.py":
        assert found
    else:
        assert found == OTHERS.get(name, set())


@pytest.mark.parametrize(
    "source",
    [
        "from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy",
        "import ctypes",
        "from rclpy.waitable import Waitable",
        "subscription.handle.take_message(Bool, False)",
        "handle.pointer",
        "from rclpy.executors import await_or_execute",
    ],
)
def test_the_rule_finds(source: str) -> None:
    assert private_parts(source)


def test_this_rclpy_is_supported() -> None:
    require_supported()


@pytest.mark.parametrize(
    ("owner", "name", "sentence"),
    [
        (rclpy_private._rclpy, "RCLError", "RCLError of rclpy"),  # noqa: SLF001 - rclpy's C module has no other name
        (rclpy_private._rclpy, "WaitSet", "wait of rclpy's WaitSet"),  # noqa: SLF001 - as above
        (rclpy_private.ActionServer, "execute", "execute of rclpy.action.ActionServer"),
        (rclpy_private.Client, "get_pending_request", "get_pending_request of rclpy.client.Client"),
        (rclpy_private, "_rcl", "rcl_take of librcl.so"),
    ],
)
def test_a_missing_part_is_named_with_the_version(
    owner: object, name: str, sentence: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if owner is rclpy_private:
        monkeypatch.setattr(owner, name, None)
    else:
        monkeypatch.delattr(owner, name)
    with pytest.raises(
        UnsupportedRclpyError, match=r"^rclpy [79]\.\d+\.\d+ is not supported, because it lacks "
    ) as raised:
        create_context()
    assert sentence in str(raised.value)


def test_a_docking_node_ends_with_one_line(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.delattr(rclpy_private.Client, "get_pending_request")

    def body(args: object) -> int:
        with ros_context([]):
            raise AssertionError

    assert run_process(body, []) == EXIT_USAGE
    error = capsys.readouterr().err
    assert error.startswith("error: rclpy ")
    assert error.count("\n") == 1


@pytest.fixture
def node(domain: int) -> Iterator[Node]:
    context: Context = create_context([], domain_id=domain)
    node = Node(f"node_{uuid.uuid4().hex}", context=context)
    yield node
    node.destroy_node()
    context.try_shutdown()


@pytest.mark.ros
def test_a_taken_message_has_its_publisher_as_the_graph_has_it(node: Node) -> None:
    """The layout of C structures is right on this machine."""
    subscription = node.create_subscription(Bool, "stop", print, LATCHED)
    publisher = node.create_publisher(Bool, "stop", LATCHED)
    before = node.get_clock().now().nanoseconds
    publisher.publish(Bool(data=True))
    taken = wait_until(lambda: take_bool(subscription), "the message")
    assert taken.data
    assert taken.publisher == bytes(node.get_publishers_info_by_topic("stop")[0].endpoint_gid)
    assert taken.stamp_ns >= before
    assert take_bool(subscription) is None
