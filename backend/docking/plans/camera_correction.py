"""After a miss: measures where the camera is, and corrects the detections of the rest of the goal."""

from dataclasses import replace

from docking.core.geometry import Pose
from docking.core.observation import MarkerDetection, Observation
from docking.estimation.camera_offset import CameraOffset, Offset
from docking.goal.plan import NothingLeftToTry

SURE = 0.005
"""Standard deviation of the offset, in m, that is good enough."""
LEAST = 0.012
"""An offset that matters, in m: contacts forgive less than about two of them."""
DEVIATIONS = 2.5
"""Standard deviations that an offset must have to be more than noise."""
MOST = 0.05
"""The largest offset, in m, that the robot relies on without a calibration."""
ADVICE = (
    "correct the camera's mounting pose in tf, or put the robot on its dock and call calibrate_dock, which sets"
    " external_detection_translation_x and _y"
)


class CameraCorrection:
    """What a goal knows of where its camera is.

    Attributes:
        applied: The offset that detections are corrected by; None while there is none.
        measured: The last measurement; None before it.
    """

    def __init__(self) -> None:
        """Begin with a camera where it is taken to be."""
        self.applied: Offset | None = None
        self.measured: Offset | None = None
        self._offset = CameraOffset()
        self._added_at = 0.0

    def correct(self, observation: Observation) -> Observation:
        """Return an observation with the detections of a camera where it is taken to be."""
        odometry, offset = observation.odometry, self.applied
        if offset is None or odometry is None or observation.marker is None:
            return observation

        def moved(detection: MarkerDetection) -> MarkerDetection:
            robot = odometry.pose
            seen = detection.pose.relative_to(robot)
            return replace(detection, pose=robot.compose(Pose(seen.x + offset.x, seen.y + offset.y, seen.theta)))

        others = tuple(moved(one) for one in observation.other_markers)
        return replace(observation, marker=moved(observation.marker), other_markers=others)

    def add(self, marker: Pose | None, seen_at: float, robot: Pose | None) -> None:
        """Take a detection in; the same one may be given again.

        Args:
            marker: In odom.
            seen_at: When it was seen.
            robot: base_link in odom.
        """
        if marker is None or robot is None or self.applied is not None or seen_at == self._added_at:
            return
        self._added_at = seen_at
        self._offset.add(marker, robot)

    def knows(self) -> bool:
        """Whether the offset is known well enough."""
        self.measured = self._offset.measure() or self.measured
        return self.measured is not None and self.measured.deviation <= SURE

    def conclude(self) -> str:
        """Correct the detections from now on, where the camera is elsewhere; return what to do about it.

        Raises:
            NothingLeftToTry: It is too far away for that.
        """
        self.knows()
        offset = self.measured
        if offset is None or self.applied is not None:
            return ""
        ways = [
            f"{abs(1000.0 * way):.0f} mm {to if way > 0.0 else other}"
            for way, to, other in ((offset.y, "to the left", "to the right"), (offset.x, "ahead", "behind"))
            if abs(way) > max(LEAST, DEVIATIONS * offset.deviation)
        ]
        if not ways:
            return ""
        sentence = f"the camera seems to be {' and '.join(ways)} of where tf has it: {ADVICE}"
        if max(abs(offset.x), abs(offset.y)) > MOST:
            raise NothingLeftToTry(sentence)
        self.applied = offset
        return f"{sentence}. This goal corrected it"
