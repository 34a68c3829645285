"""Reaches an action server through another DDS participant when it does not answer through the common one.

After an outage of about 20 s (a robot that leaves the Wi-Fi) Fast DDS may leave one or both directions silent for
minutes: one side has removed the other, but not vice versa. A participant that the server has never seen is not
affected. It is created during the outage, and used only if the server answers it and not the common one.
"""

import asyncio
import logging
import time
from dataclasses import dataclass

from dock_gateway.core.errors import GatewayError
from dock_gateway.goals.limits import LIMITS, GoalLimits
from dock_gateway.goals.liveness import ServerWatch
from dock_gateway.goals.tracker import GoalTracker

log = logging.getLogger(__name__)

# Seconds of silence after which a server is no longer tried, because its robot is switched off.
GIVE_UP_AFTER = 600.0
# The same for a server that has no goal and has left the graph.
GIVE_UP_IDLE_AFTER = 60.0
# Seconds for which another participant is tried.
KEEP = 60.0
# Seconds before another participant is tried again. They double after each try without an answer.
PAUSE = 10.0
# Maximum seconds of that pause.
LONGEST_PAUSE = 600.0
INTERVAL = 0.5


@dataclass
class RejoinSchedule:
    """Decides when another participant is tried for an action server. All times are on the monotonic clock."""

    unanswered_for: float = LIMITS.unanswered_for
    _ended: float = float("-inf")
    _pause: float = PAUSE

    def due(self, now: float, *, unanswered_since: float | None, last_heard: float, wanted: bool) -> bool:
        """Return whether to try.

        Args:
            now: The current time.
            unanswered_since: When the server began not to answer; None if it answers.
            last_heard: When the server last gave a sign of life.
            wanted: Whether it may have a goal, or is on the graph.
        """
        if unanswered_since is None or now - unanswered_since < self.unanswered_for or now - self._ended < self._pause:
            return False
        return now - last_heard < (GIVE_UP_AFTER if wanted else GIVE_UP_IDLE_AFTER)

    def ended(self, now: float, *, answered: bool) -> None:
        """Note that a try has ended, and whether the server answered, through whichever participant."""
        pause = PAUSE if answered else 2 * self._pause
        self._ended, self._pause = now, min(pause, LONGEST_PAUSE)


class Rejoiner:
    """Tries another participant for one action when it is due, and the common one again later.

    Args:
        tracker: The goals on that action.
        watch: The watch of its server, which notes when that is reached another way.
        limits: When to try.
    """

    def __init__(self, tracker: GoalTracker, watch: ServerWatch, limits: GoalLimits = LIMITS) -> None:
        self._tracker = tracker
        self._port = tracker.port
        self._watch = watch
        self._schedule = RejoinSchedule(limits.unanswered_for)
        self._home_after = limits.home_after

    async def run(self) -> None:
        """Rejoin the action whenever its server does not answer, until canceled."""
        home_at = 0.0
        while True:
            await asyncio.sleep(INTERVAL)
            try:
                if self._due():
                    await self._rejoin()
                    home_at = time.monotonic() + self._home_after
                elif self._port.away and time.monotonic() > home_at:
                    home_at = time.monotonic() + self._home_after
                    if await self._port.go_home():
                        log.info("%s is reached through the common participant again", self._port.action_name)
                        self._watch.reconcile()
            except GatewayError as error:
                log.info("%s is not tried another way: %s", self._port.action_name, error.detail)
            except Exception:
                log.exception("while %s was tried another way", self._port.action_name)

    def _due(self) -> bool:
        return self._port.answered and self._schedule.due(
            time.monotonic(),
            unanswered_since=self._port.unanswered_since,
            last_heard=self._tracker.last_heard,
            wanted=bool(self._tracker.live) or self._watch.state.available,
        )

    async def _rejoin(self) -> None:
        name = self._port.action_name
        log.info("%s does not answer; another DDS participant is tried, too", name)
        moved = False
        try:
            moved = await self._port.rejoin(KEEP)
        finally:
            self._schedule.ended(time.monotonic(), answered=self._port.unanswered_since is None)
        if moved:
            log.warning("%s answers only through another DDS participant, which is used from now on", name)
            self._watch.reconcile()
