"""Readings of the robot's sensors, with the odometry of that moment."""

from dataclasses import dataclass

from docking.core.geometry import Pose
from docking.simulation.laser import Distances


@dataclass(frozen=True, slots=True)
class Sighting:
    """The marker as the camera saw it.

    Attributes:
        marker: In base_link at that moment.
        odometry: base_link in odom at that moment, as it was known when the detection arrived.
        stamp: The detection's, in simulated seconds.
        at: When the odometry of that moment arrived, or the detection if that was earlier.
    """

    marker: Pose
    odometry: Pose
    stamp: float
    at: float


@dataclass(frozen=True, slots=True, eq=False)
class LaserScan:
    """A reading of the laser scanner.

    Attributes:
        distances: By ray, in m; infinite where nothing is seen.
        odometry: base_link in odom at that moment.
        stamp: Simulated seconds.
    """

    distances: Distances
    odometry: Pose
    stamp: float
