"""The common part of the plans that see the dock: their stages, and the way back from the dock."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace

from docking.behaviors.combined import Reversed, Sequence
from docking.behaviors.explore import Explore
from docking.behaviors.moves import bounded
from docking.behaviors.press_again import press_again
from docking.behaviors.push import Push
from docking.behaviors.search import Search
from docking.behaviors.staging import ToStaging
from docking.behaviors.straight import BackOut
from docking.core.errors import Stage
from docking.core.geometry import Pose
from docking.core.observation import Observation
from docking.estimation.dock_estimate import Spread
from docking.estimation.stall import stalls
from docking.goal.behavior import Behavior
from docking.goal.plan import DockTarget
from docking.parameters import DockSettings
from docking.plans.places import circles, may_be_seen, way_to_front

NEARBY = 0.3
"""In m; a robot that is so near to its staging pose need not drive there to see its dock."""
ANYHOW = Spread(math.inf, math.inf)
"""How well the docked pose must be known at the staging pose where nothing comes after it."""
BLIND_WAY = 0.1
"""How far to back off, in m, where the dock is not known."""


class SightedPlan(DockTarget):
    """Half a plan: the other half knows where the dock is, by one kind of sensor."""

    stages = (Stage.INITIAL_PERCEPTION, Stage.NAV_TO_STAGING_POSE, Stage.CONTROLLING, Stage.WAIT_FOR_CHARGE)

    def __init__(self, settings: DockSettings) -> None:
        """Start with no estimate of the dock.

        Args:
            settings: The robot's limits, and its docked pose relative to the detection.
        """
        self.motion = settings.motion
        self.dock = settings.dock
        self.approach = settings.approach
        self.recovery = settings.recovery
        self._stall = settings.stall
        self._stalled = False
        self._search_speed = settings.search_speed
        self._detection_timeout = settings.external_detection_timeout
        self._where = settings.search
        self._last_docked = settings.last_docked
        self._in_database: Pose | None = None  # the docked robot there, looking into the dock, in odom
        self._robot: Pose | None = None
        self._explore: Explore | None = None
        self._push: Push | None = None
        self._circles: Iterator[Pose] | None = None

    @property
    def staging(self) -> Pose | None:
        """The pose where base_link waits in front of the dock, in odom."""
        docked = self.docked
        return None if docked is None else self.dock.staging(docked)

    def observe(self, observation: Observation) -> None:
        """Keep up with the robot."""
        if self._push is not None:
            self._push.pushing = False
        self._in_database = observation.expected_dock or self._in_database
        self._stalled = stalls(observation, self._stall)
        if observation.odometry is not None:
            self._robot = observation.odometry.pose

    @property
    def stalled(self) -> bool:
        """Whether the joints of the wheels tell that these stall."""
        return self._stalled

    @property
    def pushes(self) -> bool:
        """Whether the robot was to push against the dock in the last step."""
        return self._push is not None and self._push.pushing

    def push_on(self, approach: Callable[[], Behavior]) -> Behavior:
        """The approach, and the push after it where there is one.

        Args:
            approach: Makes the behavior that ends at the contacts.
        """
        return Sequence(approach, self._make_push) if self.approach.final_push > 0.0 else approach()

    def _make_push(self) -> Push:
        self._push = Push(self.approach.final_push, self.motion)
        return self._push

    @property
    def expected(self) -> Pose | None:
        """The pose where the robot should dock, looking into the dock, in odom; None where nothing tells."""
        return self.docked or self._in_database or self._last_docked

    @property
    def _is_certain(self) -> bool:
        """Whether the expected pose is more than where the robot docked some time ago: odometry drifts."""
        return self.docked is not None or self._in_database is not None

    @property
    def explores(self) -> bool:
        """Whether the robot drives about to find the dock."""
        return self._explore is not None and self._explore.away

    def begin(self) -> None:
        """A stage begins: what drove about to find the dock before drives no longer."""
        self._explore = None

    def explore(self, search: Callable[[], Search], sees: Callable[[float], bool]) -> Explore:
        """Look for the dock, by driving, too, where that is allowed.

        Args:
            search: Makes what turns the robot at a place.
            sees: Whether the dock is in view at a moment.
        """
        robot, expected = self._robot, self.expected
        self._explore = Explore(
            search,
            self._places(expected),
            replace(self.motion, v_linear_max=self.motion.v_linear_back),
            sees,
            at_once=robot is not None and self._is_certain and not may_be_seen(robot, expected or robot),
        )
        return self._explore

    def _places(self, docked: Pose | None) -> Iterator[Pose]:
        """From where the dock may be seen, in odom."""
        robot = self._robot
        if robot is None:
            return
        if docked is not None:
            staging = self.dock.staging(docked)
            if NEARBY < robot.distance_to(staging) <= self._where.known_dock_radius:
                yield from way_to_front(robot, docked, staging)
        if self._circles is None:
            self._circles = circles(robot, self._where.search_radius)
        yield from self._circles

    def back_off(self) -> Behavior:
        """Away from the dock to where the staging pose is, or a little where that is not known.

        That is forwards where its back is turned to the dock. If that is not known, the end that sees is.
        """
        staging, distance = -self.dock.staging_x_offset, BLIND_WAY
        turned = self.dock.backward and not self.dock.rotate_to_dock
        if self._robot is not None and self.docked is not None:
            off = self._robot.relative_to(self.docked)
            distance, turned = staging + off.x, abs(off.theta) > 0.5 * math.pi
        back_out = BackOut(bounded(distance, staging), self.motion)
        return Reversed(back_out) if turned else back_out

    def correct(self, number: int) -> Behavior:
        """A small move on the contacts; see `RecoveringPlan`."""
        overshoot = self.approach.docking_overshoot
        again = self.push_on(lambda: press_again(number, self.recovery, self.motion, overshoot))
        return Reversed(again) if self.dock.backward else again

    def way_back(self) -> Behavior:
        """Straight away from the dock, then to the staging pose where that is near; see `RecoveringPlan`."""
        return Sequence(self.back_off, self._back_to_staging)

    def _back_to_staging(self) -> Behavior:
        robot, staging = self._robot, self.staging
        if robot is None or staging is None or robot.distance_to(staging) > NEARBY:
            return Sequence()
        to_staging = ToStaging(self, self.dock, self.motion, ANYHOW)
        return Reversed(to_staging) if self.dock.backward and not self.dock.rotate_to_dock else to_staging
