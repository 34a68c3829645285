"""What the modules of docking import."""

import ast
from pathlib import Path

import docking
import robot_io

PACKAGE = Path(docking.__file__).parent
MODULES = sorted(PACKAGE.rglob("*.py"))
ROS = {"rclpy", "action_msgs", "action_tutorials_interfaces", "diagnostic_msgs", "geometry_msgs", "nav_msgs"}
# Our own modules that import ROS.
ROS_PARTS = {"docking.ros"} | {f"robot_io.{path.stem}" for path in Path(robot_io.__file__).parent.glob("*.py")}
ROS_PARTS -= {"robot_io.__init__", "robot_io.velocity_types", "robot_io.stop_votes"}
ROS_PARTS -= {"robot_io.laser", "robot_io.recording", "robot_io.transform", "robot_io.transform_tree"}
ROS_PARTS -= {"robot_io.docking_messages", "robot_io.installation", "robot_io.ros_variables", "robot_io.startup"}
ROS |= {"rcl_interfaces", "sensor_msgs", "std_msgs", "std_srvs", "unique_identifier_msgs"}


def imported(module: Path) -> set[str]:
    """Return the packages that a module imports, and which of `ROS_PARTS`."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(module.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module.split(".")[0]}
            names |= {name for name in ROS_PARTS if node.module.startswith(name)}
    return names
