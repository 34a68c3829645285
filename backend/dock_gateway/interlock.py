"""The interlock: while a stop is latched, no goal is sent to the robot.

The latch is told on the topic `stop_latched` of each robot, whose last message counts: the action server and the base
obey it, other gateways learn it. It is kept in a file, so that a crash releases nothing.
"""

import asyncio
import logging
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Protocol

from dock_gateway.errors import Conflict
from dock_gateway.events import system_event, utc_now
from dock_gateway.hub import Hub
from dock_gateway.latch import Latch, Latches, LatchFile
from dock_gateway.namespaces import is_under
from dock_gateway.tasks import cancel

log = logging.getLogger(__name__)

# What was learned from another gateway is said by this one, too, after so many seconds without a contradiction: the
# other may go, and those who come later would hear of nothing.
ECHO_AFTER = 0.5
CLOSE_WITHIN = 0.5


class LatchTopic(Protocol):
    """`stop_latched` of one robot."""

    async def publish(self, *, latched: bool) -> None:
        """Say it; who comes later hears the last that was said."""

    async def withdraw(self) -> None:
        """Who comes later hears nothing from us."""


class Interlock:
    """Which robots are held by a stop, and who has to know.

    Args:
        hub: Where events go.
        file: Where it is kept.
        default: The configured robot.
    """

    def __init__(self, hub: Hub, file: LatchFile, default: str) -> None:
        self._hub = hub
        self._file = file
        self._latches = Latches(file.read(default))
        self._topics: dict[str, LatchTopic] = {}
        self._said: dict[str, bool] = {}
        self._shown: dict[str, dict[str, Any]] = {}
        self._echoes: dict[str, asyncio.Task[None]] = {}
        self._written: asyncio.Future[None] | None = None
        self._closing = False
        self._disk = ThreadPoolExecutor(1, thread_name_prefix="latch")
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
        """The latch as `GET /stop` shows it."""
        return self._latches.document(namespace, {*self._topics, *self._latches.held})

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
        self._shown[namespace] = self.document(namespace)
        self._show()

    def leave(self, namespace: str) -> None:
        """A robot that is not held has gone."""
        for known in (self._topics, self._shown, self._said):
            known.pop(namespace, None)
        if (echo := self._echoes.pop(namespace, None)) is not None:
            echo.cancel()

    def latch(self, namespace: str, by: str | None = None) -> "asyncio.Future[None]":
        """Refuse goals for a robot and those below it from now on; returns the writing of the file.

        `tell` says it to the others.
        """
        log.warning("a stop of %s is latched%s", namespace, f" by {by}" if by else "")
        latch = Latch(utc_now(), by)
        for name in self._below(namespace):
            self._latches.latch(name, latch)
        return self._changed()

    async def release(self, namespace: str) -> None:
        """Let goals through again, for a robot and those below it.

        Raises:
            Conflict: `stop_latched`: a stop of a namespace above holds for it.
            Unavailable: The ROS thread is down.
        """
        over = self._latches.over(namespace)
        if over is not None and not is_under(over, namespace):
            raise Conflict(f"the stop of {over} holds for {namespace}, too: release that", code="stop_latched")
        log.warning("the stop of %s is released", namespace)
        below = self._below(namespace)
        for name in below:
            self._latches.release(name)
        written = self._changed()
        await self._tell(below)
        await written

    async def tell(self, namespace: str) -> None:
        """Say on the topics of a robot, and of those below it, whether it is held.

        Raises:
            Unavailable: The ROS thread is down.
        """
        await self._tell(self._below(namespace))

    async def _tell(self, names: list[str]) -> None:
        for name in names:
            if (topic := self._topics.get(name)) is not None:
                latched = self.holds(name)
                self._said[name] = latched
                await topic.publish(latched=latched)

    def _below(self, namespace: str) -> list[str]:
        names = {namespace, *self._topics, *self._latches.held}
        return sorted(name for name in names if is_under(name, namespace))

    # ------------------------------------------------------------------ what another gateway says

    def heard(self, namespace: str, *, latched: bool) -> None:
        """Another gateway latched a robot, or released it."""
        if self._closing or latched == (namespace in self._latches.held):
            return
        log.warning("another gateway %s the stop of %s", "latched" if latched else "released", namespace)
        if latched:
            self._latches.latch(namespace, Latch(utc_now()))
        else:
            self._latches.release(namespace)
        self._changed()
        self._echo(namespace)

    def _echo(self, namespace: str) -> None:
        if (before := self._echoes.pop(namespace, None)) is not None:
            before.cancel()
        self._echoes[namespace] = asyncio.create_task(self._echo_later(namespace))

    async def _echo_later(self, namespace: str) -> None:
        """Only a stop is said again: where two gateways cross each other, it wins.

        So does one of a namespace above, of which a gateway that released the robot may not know.
        """
        await asyncio.sleep(ECHO_AFTER)
        over = self._latches.over(namespace)
        latched = over is not None
        if over is not None and namespace not in self._latches.held:
            log.warning("the stop of %s holds for %s, too: it is said again", over, namespace)
            self._latches.latch(namespace, self._latches.held[over])
            self._changed()
        elif latched == self._said.get(namespace, False):
            return
        try:
            if latched:
                await self._topics[namespace].publish(latched=True)
            else:
                await self._topics[namespace].withdraw()
        except Exception:
            log.exception("stop_latched of %s could not be published", namespace)
        else:
            self._said[namespace] = latched

    # ------------------------------------------------------------------ who has to know

    def _changed(self) -> "asyncio.Future[None]":
        self._show()
        loop = asyncio.get_running_loop()
        self._written = loop.run_in_executor(self._disk, self._write, dict(self._latches.held))
        return self._written

    def _show(self) -> None:
        now = utc_now()
        for namespace in self._topics:
            document = self.document(namespace)
            if document != self._shown.get(namespace):
                self._shown[namespace] = document
                self._hub.publish(system_event("stop", document, now, robot=namespace))

    def _write(self, held: dict[str, Latch]) -> None:
        try:
            self._file.write(held)
        except OSError:
            log.exception("the stop could not be written to %s: a restart would forget it", self._file.path)

    async def close(self) -> None:
        """Write what is to be written, where the disk does not hang."""
        self._closing = True
        await cancel(*self._echoes.values())
        if self._written is not None:
            await asyncio.wait([self._written], timeout=CLOSE_WITHIN)
        self._disk.shutdown(wait=False)
