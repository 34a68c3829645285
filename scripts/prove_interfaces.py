"""Tries the installed interface package as ROS programs and the ROS tools use it.

Run by `scripts/interfaces-wheel` in an environment that holds the package and the ROS wheels, nothing else.
"""

import ctypes
import importlib
import math
import platform
import sys
from importlib.metadata import version
from pathlib import Path

from ament_index_python.packages import get_package_prefix, get_package_share_directory
from ament_index_python.resources import get_resource, get_resources
from rclpy.serialization import deserialize_message, serialize_message
from rclpy.type_support import check_for_type_support

PACKAGE = "action_tutorials_interfaces"
PREFIX = Path(sys.prefix).resolve()

BATTERY_FIELDS = {
    "Goal": {"desired_battery_state": "sensor_msgs/BatteryState"},
    "Result": {"final_battery_state": "sensor_msgs/BatteryState"},
    "Feedback": {"current_battery_state": "sensor_msgs/BatteryState"},
}
FIELDS = {
    "Fibonacci": {
        "Goal": {"order": "int32"},
        "Result": {"sequence": "sequence<int32>"},
        "Feedback": {"partial_sequence": "sequence<int32>"},
    },
    "ConnectToChargingDock": BATTERY_FIELDS,
    "DisconnectFromChargingDock": BATTERY_FIELDS,
}
TYPESUPPORTS = [
    "rosidl_generator_c",
    "rosidl_generator_py",
    "rosidl_typesupport_c",
    "rosidl_typesupport_cpp",
    "rosidl_typesupport_fastrtps_c",
    "rosidl_typesupport_fastrtps_cpp",
    "rosidl_typesupport_introspection_c",
    "rosidl_typesupport_introspection_cpp",
]


def expect(is_so: bool, what: str) -> None:
    """Print what was found to be so, or end the program."""
    if not is_so:
        sys.exit(f"  not so: {what}")
    sys.stdout.write(f"  {what}\n")


def prove_imports() -> None:
    """Every action imports, from this environment, with the fields that the definitions name."""
    actions = importlib.import_module(f"{PACKAGE}.action")
    expect(PREFIX in Path(str(actions.__file__)).resolve().parents, "imported from this environment")
    for name, parts in FIELDS.items():
        action = getattr(actions, name)
        check_for_type_support(action)
        for part, fields in parts.items():
            found = getattr(action, part).get_fields_and_field_types()
            expect(found == fields, f"{name}.{part}: {', '.join(f'{t} {f}' for f, t in fields.items())}")


def prove_round_trips() -> None:
    """A message that becomes CDR bytes, as it does on the network, comes back as it was."""
    actions = importlib.import_module(f"{PACKAGE}.action")

    sequence = actions.Fibonacci.Result(sequence=[0, 1, 1, 2, 3, -(2**31), 2**31 - 1])
    expect(deserialize_message(serialize_message(sequence), type(sequence)) == sequence, "Fibonacci through CDR")

    message_type = actions.ConnectToChargingDock.Impl.FeedbackMessage
    sent = message_type()
    sent.goal_id.uuid = list(range(16))
    battery = sent.feedback.current_battery_state
    battery.header.frame_id = "dock_é"
    battery.voltage, battery.percentage, battery.temperature = 2.16, 0.24, math.nan
    battery.power_supply_status = battery.POWER_SUPPLY_STATUS_CHARGING
    battery.cell_voltage = [1.25, math.inf]
    received = deserialize_message(serialize_message(sent), message_type)
    came_back = received.feedback.current_battery_state
    expect(
        list(received.goal_id.uuid) == list(range(16))
        and came_back.header.frame_id == "dock_é"
        and math.isclose(came_back.voltage, 2.16, rel_tol=1e-6)
        and math.isclose(came_back.percentage, 0.24, rel_tol=1e-6)
        and math.isnan(came_back.temperature)
        and came_back.power_supply_status == battery.POWER_SUPPLY_STATUS_CHARGING
        and list(came_back.cell_voltage) == [1.25, math.inf],
        "ConnectToChargingDock feedback through CDR",
    )


def prove_files() -> None:
    """Definitions, index entries and libraries lie where the ROS tools look for them."""
    expect(Path(get_package_prefix(PACKAGE)).resolve() == PREFIX, "ament index: packages")
    share = Path(get_package_share_directory(PACKAGE))
    for file in ("package.xml", *(f"action/{name}.action" for name in FIELDS)):
        expect((share / file).is_file(), f"share/{PACKAGE}/{file}")
    # `ros2 interface list` and `ros2 interface show` read this entry.
    expect(PACKAGE in get_resources("rosidl_interfaces"), "ament index: rosidl_interfaces")
    listed = get_resource("rosidl_interfaces", PACKAGE)[0].split()
    expect(all(f"action/{name}.action" in listed for name in FIELDS), "ament index: every action listed")
    for typesupport in TYPESUPPORTS:
        library = PREFIX / "lib" / f"lib{PACKAGE}__{typesupport}.so"
        ctypes.CDLL(str(library))
        expect(True, f"lib/{library.name} loads")


if __name__ == "__main__":
    prove_imports()
    prove_round_trips()
    prove_files()
    sys.stdout.write(
        f"OK: {PACKAGE} {version('action-tutorials-interfaces')} works on CPython {platform.python_version()} "
        f"with rclpy {version('ros-rclpy')}.\n"
    )
