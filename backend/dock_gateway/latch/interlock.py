"""The interlock: while a stop is latched, no goal is sent to the robot and none may run.

The latch is told on the topic `stop_latched` of each robot, whose last message counts: the action server and the base
obey it, other gateways learn it. It is kept in a file, so that a crash releases nothing.
"""

import asyncio
import logging
import math
import time
from collections.abc import Callable
from typing import Any, Protocol

from dock_gateway.core.errors import Conflict, Unavailable
from dock_gateway.core.event import system_event, utc_now
from dock_gateway.core.filters import is_under
from dock_gateway.core.hub import Hub
from dock_gateway.core.tasks import cancel
from dock_gateway.latch.latch_file import LatchFile, LatchWriter
from dock_gateway.latch.latches import Latch, Latches

log = logging.getLogger(__name__)

# What was learned from another gateway is said by this one, too, after so many seconds without a contradiction: the
# other may go, and those who come later would hear of nothing. What could not be published is tried again as often.
ECHO_AFTER = 0.5
# What was said, and not contradicted, is not said again within so many seconds.
SAY_AGAIN_AFTER = 1.0
# Seconds that a release waits for the disk.
STORE_WITHIN = 0.08


class LatchTopic(Protocol):
    """`stop_latched` of one robot."""

    def publish(self, *, latched: bool) -> None:
        """Publish it, now; late subscribers get the last message."""

    async def withdraw(self) -> None:
        """Late subscribers get no message from us any more."""


class Interlock:
    """Which robots are held by a stop, and who has to know.

    Args:
        hub: Where events go.
        file: Where it is kept.
        default: The configured robot.

    Attributes:
        on_latch: What is called with a robot that is held by a stop which another gateway carried out.
    """

    def __init__(self, hub: Hub, file: LatchFile, default: str) -> None:
        self.on_latch: list[Callable[[str], None]] = []
        self._hub = hub
        self._latches = Latches(file.read(default))
        self._writer = LatchWriter(file, self._show_soon)
        self._topics: dict[str, LatchTopic] = {}
        # What each topic was told last by us; None where that failed, so that nobody knows what was heard.
        self._said: dict[str, bool | None] = {}
        self._said_at: dict[str, float] = {}
        # When each stop that was asked for here was told to others, on the monotonic clock.
        self._told_at: dict[str, float] = {}
        self._documents: dict[str, dict[str, Any]] | None = None  # of every robot, until something changes
        self._shown: dict[str, dict[str, Any]] = {}
        self._showing: asyncio.Handle | None = None
        self._echoes: dict[str, asyncio.Task[None]] = {}  # topics that may not say what holds
        self._closing = False
        if self._latches.held:
            log.warning("a stop is latched for %s; release it to go on", ", ".join(sorted(self._latches.held)))

    # ------------------------------------------------------------------ what is asked

    def holds(self, name: str) -> bool:
        """Whether a stop holds for a namespace or an action."""
        return self._latches.over(name) is not None

    def require_released(self, action_name: str) -> None:
        """Make sure that a goal may be sent.

        Raises:
            Conflict: `stop_latched`.
        """
        over = self._latches.over(action_name)
        if over is not None:
            by = self._latches.held[over].by
            detail = f"{over} was stopped{f' by {by}' if by else ''}: no goal is sent until the stop is released"
            raise Conflict(f"{detail} (DELETE /stop)", code="stop_latched")

    def document(self, namespace: str) -> dict[str, Any]:
        """The latch of a robot that has joined, as `GET /stop` shows it."""
        if self._documents is None:
            persisted = self._writer.problem is None
            documents = self._latches.documents({*self._topics, *self._latches.held})
            self._documents = {name: document | {"persisted": persisted} for name, document in documents.items()}
        return self._documents[namespace]

    def shown(self, namespace: str) -> dict[str, Any]:
        """The latch of a robot that has joined, as subscribers were told of it last; cheaper than `document`."""
        return self._shown[namespace]

    # ------------------------------------------------------------------ what is done

    def join(self, namespace: str, topic: LatchTopic) -> None:
        """A robot has come; where a stop holds for it, it is told."""
        self._topics[namespace] = topic
        over = self._latches.over(namespace)
        if over is not None:
            self._latches.latch(namespace, self._latches.held[over])
            self._echo(namespace)
        self._show_soon()
        self._shown[namespace] = self.document(namespace)

    def leave(self, namespace: str) -> None:
        """A robot that is not held has gone."""
        for known in (self._topics, self._shown, self._said, self._said_at, self._told_at):
            known.pop(namespace, None)
        self._documents = None
        if (echo := self._echoes.pop(namespace, None)) is not None:
            echo.cancel()

    def latch(self, namespace: str, by: str | None = None) -> None:
        """Refuse goals for a robot and those below it from now on. `tell` says it to the others."""
        latch = Latch(utc_now(), by)
        new = [name for name in self._below(namespace) if self._latches.latch(name, latch)]
        if new:
            self._told_at.update(dict.fromkeys(new, math.inf))
            log.warning("a stop of %s is latched%s", namespace, f" by {by}" if by else "")
            self._changed()

    async def release(self, namespace: str) -> None:
        """Let goals through again, for a robot and those below it.

        Raises:
            Conflict: `stop_latched`: a stop of a namespace above holds for it.
        """
        over = self._latches.over(namespace)
        if over is not None and not is_under(over, namespace):
            raise Conflict(f"the stop of {over} holds for {namespace}, too: release that", code="stop_latched")
        held = [name for name in self._below(namespace) if self._let_go(name)]
        if held:
            log.warning("the stop of %s is released", namespace)
            self._changed()
        self.tell(namespace)
        await self._writer.wait(STORE_WITHIN)

    async def stored(self, timeout: float) -> Unavailable | None:
        """Wait until what is latched is on the disk; returns why it is not, where it is not in time."""
        if await self._writer.wait(timeout):
            return None
        detail = f"the robot is stopped, but a restart of the gateway would forget the stop: {self._writer.problem}"
        return Unavailable(f"{detail}; the gateway tries again until it is stored", code="stop_not_persisted")

    def tell(self, namespace: str) -> None:
        """Say on the topics of a robot, and of those below it, whether it is held; on each until that succeeds.

        Who asks again gets it said again, but not hundreds of times a second.
        """
        now = time.monotonic()
        for name in self._topics.keys() & self._below(namespace):
            if self._told_at.get(name) == math.inf:
                self._told_at[name] = now
            news = self._said.get(name) is not self.holds(name) or name in self._echoes
            if (news or now - self._said_at[name] > SAY_AGAIN_AFTER) and not self._say(name):
                self._echo(name)

    def _say(self, namespace: str) -> bool:
        latched = self.holds(namespace)
        self._said_at[namespace] = time.monotonic()
        try:
            self._topics[namespace].publish(latched=latched)
        except Exception:
            log.exception("stop_latched of %s could not be published; it is tried again", namespace)
            self._said[namespace] = None
            return False
        self._said[namespace] = latched
        return True

    def _below(self, namespace: str) -> list[str]:
        """A robot and those below it that have joined or are held."""
        names = {namespace, *self._topics, *self._latches.held}
        return sorted(name for name in names if is_under(name, namespace))

    # ------------------------------------------------------------------ what another gateway says

    def heard(self, namespace: str, *, latched: bool, received: float) -> None:
        """Another gateway latched a robot, or released it.

        Args:
            namespace: The robot.
            latched: Which of the two.
            received: When that came in, on the monotonic clock. A release that came before a stop of ours was told
                cannot mean that one.
        """
        if self._closing or latched == (namespace in self._latches.held):
            return
        if not latched and received <= self._told_at.get(namespace, -math.inf):
            return
        log.warning("another gateway %s the stop of %s", "latched" if latched else "released", namespace)
        if latched:
            self._latches.latch(namespace, Latch(utc_now()))
        else:
            self._let_go(namespace)
        self._changed()
        self._echo(namespace)

    def _let_go(self, namespace: str) -> bool:
        self._told_at.pop(namespace, None)
        return self._latches.release(namespace)

    def _echo(self, namespace: str) -> None:
        if (before := self._echoes.pop(namespace, None)) is not None:
            before.cancel()
        self._echoes[namespace] = asyncio.create_task(self._echo_later(namespace))

    async def _echo_later(self, namespace: str) -> None:
        while True:
            await asyncio.sleep(ECHO_AFTER)
            try:
                if await self._settle(namespace):
                    del self._echoes[namespace]
                    return
            except Exception:
                log.exception("stop_latched of %s may not say what holds; it is tried again", namespace)

    async def _settle(self, namespace: str) -> bool:
        """Have the topic say what holds; True once it does.

        Only a stop is said again: where two gateways cross each other, it wins. So does one of a namespace above, of
        which a gateway that released the robot may not know.
        """
        over, said = self._latches.over(namespace), self._said.get(namespace, False)
        if over is not None and self._latches.latch(namespace, self._latches.held[over]):
            log.warning("the stop of %s holds for %s, too: it is said again", over, namespace)
            self._changed()
        elif said is (over is not None):
            return True
        elif said and over is None:
            self._said[namespace] = None
            await self._topics[namespace].withdraw()
            self._said[namespace] = False
            return False  # it may have been stopped meanwhile
        if over is not None:
            for told in self.on_latch:
                told(namespace)
        return self._say(namespace)

    # ------------------------------------------------------------------ who has to know

    def _changed(self) -> None:
        self._show_soon()
        self._writer.put(self._latches.held)

    def _show_soon(self) -> None:
        """Tell subscribers in a turn of the loop of its own: the stop itself does not wait for them."""
        self._documents = None
        if self._showing is None:
            self._showing = asyncio.get_running_loop().call_soon(self._show)

    def _show(self) -> None:
        self._showing = None
        now = utc_now()
        for namespace in self._topics:
            document = self.document(namespace)
            if document != self._shown.get(namespace):
                self._shown[namespace] = document
                self._hub.publish(system_event("stop", document, now, robot=namespace))

    async def close(self) -> None:
        """Store what is not stored yet, where the disk does not hang."""
        self._closing = True
        await cancel(*self._echoes.values())
        await self._writer.close()
