"""Flat markers seen nearly from the front: the heading of a detection may be mirrored at the line of sight."""

import math
from collections import deque
from dataclasses import dataclass
from statistics import median

from docking.core.geometry import Pose, normalize_angle

LEAST_NOISE = math.radians(1.0)
"""Standard deviation of a heading that is reckoned with at least, in rad."""
FIRST_NOISE = math.radians(2.0)
"""The same until it has been measured, in rad."""
MOST_NOISE = math.radians(5.0)
"""The same with which mirrored headings can be told from wrong ones: with more, any heading fits, in rad."""
NEARER = 0.53
"""How far one detection is off the nearer one of two others, in the median, as a part of the standard deviation."""
FIRST = (NEARER * FIRST_NOISE,) * 3
"""Differences that are assumed before there are any, in rad."""
RECENT = 60
"""Detections by which the noise and the share of the mirrored ones are measured."""
MEASURED = 20
"""Detections from which the noise is known well enough to tell a mirrored one from a noisy one."""
FEWEST, SHARE = 6, 0.15
"""Detections of either kind, and the part of the recent ones that must be mirrored, before any is corrected."""
FITS, APART = 3.0, 4.0
"""Standard deviations within which a detection fits a heading, and beyond which two of them are different."""
DISTINCT = 6.0
"""Standard deviations between both headings of a detection that can show whether it is mirrored."""
LOST = 12
"""Detections in a row that fit neither heading: the robot or the dock was moved."""
UNSURE = 0.005
"""Standard deviation of the marker's position across the line of sight, in m, which turns that line near the marker."""
WORST = 4.0
"""The most that one detection speaks against a heading, as the negative logarithm of a likelihood."""
BETTER = 6.0
"""By how much the other heading must be more likely before it is taken instead."""
DIRECT = 0.1
"""How much a detection that is not mirrored speaks for a heading: most detections are right."""
LEAST = -30.0
"""How unlikely the other heading can become at most."""
SETTLED = 20
"""The number of detections whose mean is the first heading."""
FOLLOWS, DRIFT = math.radians(0.1), 0.05
"""How far it follows later ones at most, in rad each, and in rad for each m driven and each rad turned.

A heading that is mirrored turns with the line of sight, twice as far. It must not be followed.
"""


@dataclass(frozen=True, slots=True)
class _Seen:
    """A detection: the marker has one of two headings.

    Attributes:
        direct: As detected, in odom, in rad.
        mirrored: At the line of sight.
        unsure: Standard deviation of twice the line of sight, in rad.
    """

    direct: float
    mirrored: float
    unsure: float

    def off(self, heading: float, noise: float) -> tuple[float, float]:
        """Return how far both are off a heading, in standard deviations.

        Args:
            heading: In odom, in rad.
            noise: Standard deviation of a detected heading, in rad.
        """
        direct, mirrored = normalize_angle(self.direct - heading), normalize_angle(self.mirrored - heading)
        return direct / noise, mirrored / self.mirrored_noise(noise)

    def mirrored_noise(self, noise: float) -> float:
        """Standard deviation of the mirrored heading, in rad."""
        return math.hypot(noise, self.unsure)

    def kind(self, heading: float, noise: float) -> int | None:
        """0 if the detection shows that heading as it is, 1 if mirrored, -1 if neither; None if it may be noise."""
        direct, mirrored = self.off(heading, noise)
        if abs(direct) <= APART:
            return 0 if abs(direct) <= abs(mirrored) else None
        if abs(normalize_angle(self.direct - self.mirrored)) <= DISTINCT * self.mirrored_noise(noise):
            return None
        return 1 if abs(mirrored) <= FITS else -1


@dataclass(slots=True)
class _Heading:
    """A heading that the marker may have.

    Attributes:
        theta: In odom, in rad.
        score: The logarithm of its likelihood, up to a constant.
        count: Detections that fitted.
    """

    theta: float
    score: float = 0.0
    count: int = 1

    def weigh(self, seen: _Seen, noise: float, drift: float) -> bool:
        """Take a detection in; return whether it fits."""
        direct, mirrored = seen.off(self.theta, noise)
        is_direct = abs(direct) <= abs(mirrored)
        off = direct if is_direct else mirrored
        self.score += (DIRECT if is_direct else 0.0) - min(0.5 * off**2, WORST)
        if abs(off) > FITS:
            return False
        self.count += 1
        # A mirrored one counts the less, the less well the line of sight is known.
        part = noise if is_direct else noise**2 / seen.mirrored_noise(noise)
        step = off * part / min(self.count, SETTLED)
        if self.count > SETTLED:
            step = math.copysign(min(abs(step), FOLLOWS + drift), step)
        self.theta = normalize_angle(self.theta + step)
        return True


class FlatMarker:
    """Finds out which of the two headings of each detection is right: only one stays where it is as the robot moves.

    Nothing is corrected before mirrored detections were seen.

    Attributes:
        mirrors: Whether some detections are mirrored.
    """

    def __init__(self) -> None:
        """Begin without a detection."""
        self.mirrors = False
        self._main: _Heading | None = None
        self._other: _Heading | None = None
        self._noise = FIRST_NOISE
        self._offs: deque[float] = deque(maxlen=RECENT)
        self._recent: deque[_Seen] = deque(maxlen=RECENT)  # since the noise has been measured
        self._unfit = 0
        self._last: float | None = None
        self._robot: Pose | None = None

    def correct(self, marker: Pose, camera: Pose, robot: Pose, known: Pose | None = None) -> tuple[Pose, bool]:
        """Return a detection with the right heading.

        Args:
            marker: As detected, in odom.
            camera: Where it was seen from, in odom.
            robot: base_link in odom.
            known: The marker as known from all detections before, in odom; only its position counts.

        Returns:
            The detection, and whether those before may have been wrong.
        """
        place = known or marker
        line_of_sight = math.atan2(place.y - camera.y, place.x - camera.x)
        unsure = 2.0 * math.atan2(UNSURE, place.distance_to(camera))
        mirrored = normalize_angle(2.0 * line_of_sight - marker.theta)
        seen = _Seen(marker.theta, mirrored, unsure)
        changed = self._weigh(seen, self._drift(robot)) or self._choose(line_of_sight) or self._begins()
        main = self._main
        if main is None or not self.mirrors:
            return marker, changed
        direct, other = seen.off(main.theta, self._noise)
        return (Pose(marker.x, marker.y, mirrored) if abs(other) < abs(direct) else marker), changed

    def _drift(self, robot: Pose) -> float:
        """Return how much the heading may have drifted in odom since the last detection, in rad."""
        last, self._robot = self._robot or robot, robot
        return DRIFT * (robot.distance_to(last) + abs(normalize_angle(robot.theta - last.theta)))

    def _weigh(self, seen: _Seen, drift: float) -> bool:
        """Take a detection in; return whether all begins again, as where the robot was moved."""
        self._learn_noise(seen)
        main = self._main
        if main is None or self._unfit >= LOST:
            began = main is not None
            self._main, self._other, self._unfit = _Heading(seen.direct), _Heading(seen.mirrored), 0
            return began and self.mirrors
        fits = [heading.weigh(seen, self._noise, drift) for heading in (main, self._other) if heading is not None]
        self._unfit = 0 if any(fits) else self._unfit + 1
        if len(self._offs) >= MEASURED:
            self._recent.append(seen)
        return False

    def _learn_noise(self, seen: _Seen) -> None:
        """By how far each detection is off the one before, whichever of its headings is nearer."""
        if self._last is not None:
            offs = (normalize_angle(heading - self._last) for heading in (seen.direct, seen.mirrored))
            self._offs.append(min(map(abs, offs)))
            self._noise = max(LEAST_NOISE, median((*self._offs, *FIRST)) / NEARER)
        self._last = seen.direct

    def _choose(self, line_of_sight: float) -> bool:
        """Take the other heading where that is more likely; return whether it was."""
        main, other = self._main, self._other
        if main is None:
            return False
        if other is None:
            mirrored = _Heading(normalize_angle(2.0 * line_of_sight - main.theta), main.score - BETTER)
            apart = abs(normalize_angle(main.theta - mirrored.theta)) > APART * self._noise
            self._other = mirrored if apart else None
            return False
        other.score = max(other.score - main.score, LEAST)
        main.score = 0.0
        apart = abs(normalize_angle(main.theta - other.theta)) > FITS * self._noise
        if other.score > BETTER and apart:
            self._main, self._other = other, main
            self._recent.clear()
            return self.mirrors
        if other.score <= LEAST or not apart:
            self._other = None
        return False

    def _begins(self) -> bool:
        """Whether the first mirrored detections were found just now; as many are wrong in another way by chance.

        The noise that is known by now decides on all recent ones: with that of the first ones, any heading fits.
        """
        main = self._main
        if self.mirrors or main is None or self._noise > MOST_NOISE:
            return False
        kinds = [seen.kind(main.theta, self._noise) for seen in self._recent]
        right, mirrored, neither = (kinds.count(kind) for kind in (0, 1, -1))
        told = right + mirrored + neither
        if 2 * told >= len(kinds):  # most detections can be told apart
            self.mirrors = right >= FEWEST and mirrored >= max(FEWEST, SHARE * told, 2 * neither)
        return self.mirrors
