"""Decides whether another server, such as nav2, drives the robot to its staging pose, and watches it. No ROS."""

import enum
from typing import Protocol

from docking.core.errors import FailedToStage
from docking.parameters import NavigationSettings

DISCOVERY = 2.0
"""Seconds to wait for the server and for the robot's pose: ROS finds their publishers one after the other."""
SILENT = 5.0
"""Seconds without an answer, or without feedback from a server that has sent some, after which it counts as dead."""


class CannotNavigate(Exception):
    """The robot cannot be driven to the staging pose now; the text says why."""


class RideState(enum.Enum):
    """The state of a request."""

    ASKED = enum.auto()
    DRIVING = enum.auto()
    REACHED = enum.auto()
    FAILED = enum.auto()


class Ride(Protocol):
    """One request to drive the robot to the staging pose.

    Attributes:
        state: Its state.
        reason: Why it failed.
        feedback: How many messages of feedback have come.
    """

    @property
    def state(self) -> RideState: ...  # noqa: D102 - see above

    @property
    def reason(self) -> str: ...  # noqa: D102

    @property
    def feedback(self) -> int: ...  # noqa: D102

    def cancel(self) -> None:
        """Stop driving, if it has not ended."""


class Navigator(Protocol):
    """Drives the robot to the staging pose."""

    def distance(self) -> float:
        """Between the robot and the staging pose, in m.

        Raises:
            CannotNavigate: The distance is unknown, or no server can drive the robot there.
        """

    def send(self) -> Ride:
        """Ask for it."""

    def skip(self, reason: str) -> None:
        """Log why the robot is not driven there."""


class Going(enum.Enum):
    """The state of a navigation."""

    WAITS = enum.auto()
    """It is not known yet whether to navigate; the robot is to stand still."""
    DRIVES = enum.auto()
    """The other server drives: no velocity is to be published."""
    OVER = enum.auto()
    """The robot is near the staging pose, or is not driven there."""


class Navigation:
    """Brings the robot near its staging pose before a plan begins. It can be interrupted, and then begins again."""

    def __init__(self, navigator: Navigator, settings: NavigationSettings) -> None:
        """Decide nothing yet.

        Args:
            navigator: Who drives.
            settings: How near the robot must be, and how long that may take.
        """
        self._navigator = navigator
        self._settings = settings
        self._ride: Ride | None = None
        self._waited = self._driven = self._silent = 0.0
        self._feedback = 0
        self._asked = False

    def step(self, dt: float) -> Going:
        """Let time pass, and say who drives now.

        Args:
            dt: Seconds since the last step.

        Raises:
            FailedToStage: The robot was not driven to the staging pose.
        """
        ride = self._ride
        self._driven += dt if self._asked else 0.0
        if ride is not None and ride.state is RideState.REACHED:
            self._ride = None
            return Going.OVER
        if ride is not None and ride.state is RideState.FAILED:
            raise FailedToStage(ride.reason)
        if self._driven > self._settings.max_staging_time:
            raise FailedToStage(
                f"navigate_to_pose did not reach the staging pose within {self._settings.max_staging_time:g} s"
                " (max_staging_time)"
            )
        if ride is None:
            return self._decide(dt)
        self._listen(ride, ride.state, dt)
        return Going.DRIVES

    @property
    def timeout(self) -> float:
        """The longest that it takes, in s, with all interruptions."""
        return self._settings.max_staging_time + DISCOVERY

    def interrupt(self) -> None:
        """Cancel the ride, if there is one: the robot must stand still now."""
        if self._ride is not None:
            self._ride.cancel()
            self._ride = None
            self._waited = 0.0

    def _decide(self, dt: float) -> Going:
        try:
            distance = self._navigator.distance()
        except CannotNavigate as error:
            self._waited += dt
            if self._waited < DISCOVERY:
                return Going.WAITS
            self._navigator.skip(str(error))
            return Going.OVER
        if distance <= self._settings.dock_prestaging_tolerance:
            return Going.OVER
        self._ride, self._asked = self._navigator.send(), True
        self._silent, self._feedback = 0.0, 0
        return Going.DRIVES

    def _listen(self, ride: Ride, state: RideState, dt: float) -> None:
        """See whether the server is alive.

        Raises:
            FailedToStage: It is silent.
        """
        no_news = self._feedback > 0 and ride.feedback == self._feedback
        waits = state is RideState.ASKED or no_news
        self._silent = self._silent + dt if waits else 0.0
        self._feedback = ride.feedback
        if self._silent > SILENT:
            missing = "did not answer" if state is RideState.ASKED else "gave no feedback"
            raise FailedToStage(f"navigate_to_pose {missing} for {SILENT:g} s")
