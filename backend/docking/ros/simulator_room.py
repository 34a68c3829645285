"""The simulated robot's knowledge of its room: the map, and ways on it."""

from collections.abc import Callable

from nav_msgs.msg import OccupancyGrid
from rclpy.node import Node

from docking.ros.navigation import NavigateToPose
from docking.ros.simulator_messages import map_message
from docking.ros.simulator_navigation import SimulatorNavigation
from docking.simulation.occupancy import map_of
from docking.simulation.room import Room
from docking.simulation.route import Routes
from docking.simulation.simulation import Simulation
from robot_io.endpoints import overridable_publisher
from robot_io.qos import LATCHED


class SimulatorRoom:
    """Publishes `map`, and offers `navigate_to_pose` where nav2_msgs is installed."""

    def __init__(self, node: Node, room: Room | None, simulation: Callable[[], Simulation]) -> None:
        """Publish the map, which never changes.

        Args:
            node: The simulator.
            room: None if there is no map, and so no navigation.
            simulation: The current one.
        """
        self.navigation: SimulatorNavigation | None = None
        if room is None:
            return
        grid = map_of(room, simulation().dock)
        self._map = overridable_publisher(node, OccupancyGrid, "map", LATCHED)
        self._map.publish(map_message(grid, node.get_clock().now().to_msg()))
        if NavigateToPose is not None:
            self.navigation = SimulatorNavigation(node, Routes(grid, simulation().robot.radius), simulation)

    @property
    def drives(self) -> bool:
        """Whether a goal of navigation runs."""
        return self.navigation is not None and self.navigation.drives

    def drive(self) -> None:
        """Command the next velocity, while a goal of navigation runs."""
        if self.navigation is not None:
            self.navigation.step()

    def interrupt(self, reason: str) -> None:
        """Stop the robot and abort the goal of navigation, if one runs.

        Args:
            reason: Why, as a sentence.
        """
        if self.navigation is not None:
            self.navigation.abort(reason)

    def close(self) -> None:
        """Leave the ROS graph, which rclpy does not do by itself."""
        if self.navigation is not None:
            self.navigation.close()
