"""After a miss: measures where the camera is, and corrects the detections from then on, also those of later goals."""

from dataclasses import replace

from docking.core.geometry import Pose
from docking.core.observation import MarkerDetection, Observation
from docking.estimation.camera_offset import CameraOffset, Offset
from docking.goal.plan import NothingLeftToTry

SURE = 0.005
"""Standard deviation of the offset, in m, that is good enough."""
SURE_ENOUGH = 0.01
"""The same for later goals to rely on it; usual are 7 mm."""
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
IN_PLACE = Pose()
"""How far a camera is from where tf has it, if nothing else is known."""


class CameraCorrection:
    """A goal's knowledge of its camera's pose: from goals before, and once, after a miss, from what is left.

    Attributes:
        applied: How far the camera is taken to be from where tf has it, in base_link; detections are corrected by it.
        kept: What later goals begin with: an offset that was measured badly is for this goal alone.
        reason: Why detections are corrected, and what to do about it, as a sentence; empty where they are not.
    """

    def __init__(self, applied: Pose = IN_PLACE) -> None:
        """Begin.

        Args:
            applied: What the last goal has learned; no way at all where that is nothing.
        """
        self.applied = self.kept = applied
        self.reason = f"{_describe(applied)}. An earlier goal measured it" if applied != IN_PLACE else ""
        self._measured: Offset | None = None  # what is left
        self._concluded = False
        self._offset = CameraOffset()
        self._added_at = 0.0

    def correct(self, observation: Observation) -> Observation:
        """Return an observation with the detections of a camera where it is taken to be."""
        odometry, offset = observation.odometry, self.applied
        if offset == IN_PLACE or odometry is None or observation.marker is None:
            return observation

        def moved(detection: MarkerDetection) -> MarkerDetection:
            robot = odometry.pose
            seen = detection.pose.relative_to(robot)
            return replace(detection, pose=robot.compose(Pose(seen.x + offset.x, seen.y + offset.y, seen.theta)))

        others = tuple(moved(one) for one in observation.other_markers)
        return replace(observation, marker=moved(observation.marker), other_markers=others)

    def add(self, marker: Pose | None, seen_at: float, robot: Pose | None) -> None:
        """Take a detection in, as it was corrected; the same one may be given again.

        Args:
            marker: In odom.
            seen_at: When it was seen.
            robot: base_link in odom.
        """
        if marker is None or robot is None or self._concluded or seen_at == self._added_at:
            return
        self._added_at = seen_at
        self._offset.add(marker, robot)

    def knows(self) -> bool:
        """Whether what is left is known well enough."""
        self._measured = self._offset.measure() or self._measured
        return self._measured is not None and self._measured.deviation <= SURE

    def conclude(self) -> bool:
        """Correct the detections by what was measured, where that is more than noise; whether anything changes.

        Raises:
            NothingLeftToTry: The camera is too far away for that.
        """
        self.knows()
        left = self._measured
        if left is None or self._concluded:
            return False
        least = max(LEAST, DEVIATIONS * left.deviation)
        if max(abs(left.x), abs(left.y)) <= least:
            return False
        camera = Pose(self.applied.x + left.x, self.applied.y + left.y)
        if max(abs(camera.x), abs(camera.y)) > MOST:
            raise NothingLeftToTry(_describe(camera))
        self._concluded = True
        if max(abs(camera.x), abs(camera.y)) <= least:
            self.applied = IN_PLACE
            self.reason = "the camera is where tf has it now, not where an earlier goal measured it"
        else:
            self.applied = camera
            self.reason = f"{_describe(camera)}. This goal corrected it"
        if left.deviation <= SURE_ENOUGH:
            self.kept = self.applied
        return True


def _describe(camera: Pose) -> str:
    ways = [
        f"{abs(1000.0 * way):.0f} mm {to if way > 0.0 else other}"
        for way, to, other in ((camera.y, "to the left", "to the right"), (camera.x, "ahead", "behind"))
        if abs(way) > LEAST
    ]
    return f"the camera seems to be {' and '.join(ways)} of where tf has it: {ADVICE}"
