"""Selects the detections of the goal's dock, where more than one marker is detected on one topic."""

from dataclasses import dataclass

from docking.core.geometry import Pose

SAME = 0.25
"""Detections nearer to each other than this, in m, are of one marker; at 0 m: it grows with the distance."""
SAME_PER_METRE = 0.03
"""How much it grows, in m, for each m between robot and marker."""
NEAR = 0.35
"""A marker so near (m) to where it is expected is the dock's; others only after the robot has looked all around."""
REPORTED = 0.1
"""The share of detections from which another marker is reported: fewer are mistakes of the detector."""
FARTHEST_PUSH = 0.4
"""How far (m) a marker that was expected may seem to move while it is followed, as when the robot is pushed."""
TURNS = 3
"""How often a marker is seen between detections of the dock's until it counts as another one."""
ENOUGH = 5
"""Detections of a marker that is not a mistake of the detector."""
DOUBTED = 15
"""Detections of each of two markers after which nothing will tell which one is the dock's."""
AHEAD = 2.0
"""How many times more often than any other one the dock's marker is detected, where nothing else tells which it is."""
MOST = 20
"""Places that are remembered."""


@dataclass(slots=True)
class _Place:
    """A place where a marker was detected, in odom.

    Attributes:
        middle: The mean of its detections.
        count: How many there were.
        turns: How often it was detected after the dock's marker, or at first.
    """

    middle: Pose
    count: int = 0
    turns: int = 0

    def add(self, marker: Pose) -> None:
        """Take a detection in."""
        self.count += 1
        share = 1.0 / min(self.count, 2 * ENOUGH)
        x = self.middle.x + share * (marker.x - self.middle.x)
        self.middle = Pose(x, self.middle.y + share * (marker.y - self.middle.y))


class MarkerSelection:
    """Decides on each detection by where the dock is expected, or was seen before.

    Attributes:
        left_out: Detections of other markers.
        other: Where most of them are, in odom; None without.
    """

    def __init__(self) -> None:
        """Expect the dock anywhere."""
        self.left_out = 0
        self._places: list[_Place] = []
        self._expected: Pose | None = None
        self._within = NEAR
        self._last_ours = False

    def expect(self, marker: Pose | None, within: float = NEAR) -> None:
        """Say where the dock's marker is.

        Args:
            marker: In odom; None where nothing is known.
            within: How far from there it may be, in m; the marker that is nearest is taken.
        """
        self._expected = marker
        self._within = within

    def forget(self) -> None:
        """Begin again: the dock's marker is looked for. Other markers are remembered."""
        self._places = [_Place(place.middle, 0, place.turns) for place in self._places if place.turns >= TURNS]

    @property
    def other(self) -> Pose | None:
        """The pose of the other marker that is detected most often, in odom."""
        all_of_them = sum(place.count for place in self._places)
        most = max(self._places, key=lambda place: place.count * (place.turns >= TURNS), default=None)
        known = most is not None and most.turns >= TURNS and most.count >= max(ENOUGH, REPORTED * all_of_them)
        return most.middle if known and most is not None else None

    @property
    def ambiguous(self) -> tuple[Pose, Pose] | None:
        """Two markers of which either may be the dock's; None while there is no doubt."""
        if self._expected is not None:
            return None
        places = sorted(self._places, key=lambda place: -place.count)[:2]
        if len(places) < 2 or places[1].count < DOUBTED or places[0].count > AHEAD * places[1].count:
            return None
        return places[0].middle, places[1].middle

    def takes(self, marker: Pose, robot: Pose, estimate: Pose | None) -> bool:
        """Whether a detection may be of the dock's marker.

        Args:
            marker: In odom.
            robot: Of base_link, in odom.
            estimate: Where the dock's marker is, as known from detections before; None at first.
        """
        same = SAME + SAME_PER_METRE * robot.distance_to(marker)
        place = self._find(marker, same)
        place.add(marker)
        if estimate is None:
            ours = self._may_be_first(place, marker)
        elif marker.distance_to(estimate) <= same:
            ours = self._last_ours = True
        else:
            place.turns += self._last_ours
            self._last_ours = False
            near = self._expected is None or marker.distance_to(estimate) <= max(same, FARTHEST_PUSH)
            ours = near and place.turns < TURNS
        self.left_out += not ours
        return ours

    def _may_be_first(self, place: _Place, marker: Pose) -> bool:
        if self._expected is None:
            others = [one.count for one in self._places if one is not place]
            return place.count > AHEAD * max(others, default=0)
        if marker.distance_to(self._expected) <= min(NEAR, self._within):
            return True
        place.turns = max(place.turns, TURNS)  # not the dock's, unless there is no better one
        known = [one for one in self._places if one.count >= ENOUGH or one is place]
        nearest = min(known, key=lambda one: one.middle.distance_to(self._expected or one.middle))
        return nearest is place and marker.distance_to(self._expected) <= self._within and self._within > NEAR

    def _find(self, marker: Pose, same: float) -> _Place:
        near = [place for place in self._places if place.middle.distance_to(marker) <= same]
        if near:
            return min(near, key=lambda place: place.middle.distance_to(marker))
        if len(self._places) >= MOST:
            self._places.remove(min(self._places, key=lambda place: place.count))
        self._places.append(_Place(marker))
        return self._places[-1]
