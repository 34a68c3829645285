"""The interlock: while a stop is latched, no goal is sent to the robot and no goal may run.

The latch is published on each robot's topic `stop_latched`, whose last message counts. The action server and the base
obey it; other gateways adopt it. It is stored in a file, so a crash does not release it.
"""

import asyncio
import logging
import math
import time
from collections.abc import Collection, Mapping
from types import MappingProxyType
from typing import Any, Protocol

from dock_gateway.core.errors import Conflict, Unavailable
from dock_gateway.core.event import stop_event, utc_now
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.filters import is_under
from dock_gateway.core.listeners import Listeners
from dock_gateway.core.namespace import ALL_ROBOTS
from dock_gateway.core.tasks import cancel
from dock_gateway.latch.latch_file import RETRY_AFTER, LatchFile, LatchWriter
from dock_gateway.latch.latches import Latch, Latches

log = logging.getLogger(__name__)

# Seconds after which a state learned from another gateway is published by this one, too, unless it is contradicted: if
# the other gateway leaves, late subscribers would get nothing. Also the seconds before a failed publish is retried.
ECHO_AFTER = 0.5
# Seconds within which an unchanged, uncontradicted state is not published again.
PUBLISH_AGAIN_AFTER = 1.0
# Maximum seconds that a release waits for the disk.
STORE_WITHIN = 0.08


class LatchTopic(Protocol):
    """The topic `stop_latched` of one robot."""

    def publish(self, *, latched: bool) -> None:
        """Publish the state now; late subscribers get the last message."""

    async def withdraw(self) -> None:
        """Withdraw our last message, so that late subscribers get none from us."""

    def held_by(self) -> str | None:
        """Return the node, not a gateway, that wants the robot to stand and is there."""

    def let_go(self) -> None:
        """Forget those who wanted the robot to stand and have left."""


class Interlock:
    """Tracks which robots are held by a stop, and publishes it.

    Args:
        fanout: Receives events.
        file: Stores the latches.
        shared: Actions of several robots, for which a stop of any robot holds.
        homes: The robots of actions that are not in the namespace of their robot.
        echo_after: See `ECHO_AFTER`.
        publish_again_after: See `PUBLISH_AGAIN_AFTER`.
        retry_after: Seconds before the file is written again after a failure.

    Attributes:
        on_latch: Called with the namespace of a robot that is held by another gateway's stop.
        on_heard: Called as soon as another gateway's stop is heard: before `on_latch`, which waits for a release that
            may have been sent at the same time.
        on_release: Called with the namespace of a robot whose stop is released, here or at another gateway.
    """

    def __init__(
        self,
        fanout: Fanout,
        file: LatchFile,
        shared: Collection[str] = (),
        homes: Mapping[str, str] = MappingProxyType({}),
        *,
        echo_after: float = ECHO_AFTER,
        publish_again_after: float = PUBLISH_AGAIN_AFTER,
        retry_after: float = RETRY_AFTER,
    ) -> None:
        self.on_latch = Listeners[[str]]("a stop is latched")
        self.on_heard = Listeners[[str]]("a stop is heard")
        self.on_release = Listeners[[str]]("a stop is released")
        self._fanout = fanout
        self._echo_after = echo_after
        self._publish_again_after = publish_again_after
        self._latches = Latches(file.read(), shared, homes)
        self._writer = LatchWriter(file, self._show_soon, retry_after=retry_after)
        self._topics: dict[str, LatchTopic] = {}
        self._places = {ALL_ROBOTS}  # namespaces that are no robots
        # The state we last published on each topic; None if that failed, so it is unknown what subscribers received.
        self._published: dict[str, bool | None] = {}
        self._unpublished: dict[str, str] = {}  # why the state could not be published
        self._published_at: dict[str, float] = {}
        # When each stop requested here was published, on the monotonic clock; infinite until then.
        self._stop_published_at: dict[str, float] = {}
        self._documents: dict[str, dict[str, Any]] | None = None  # of every robot, until something changes
        self._shown: dict[str, dict[str, Any]] = {}
        self._showing: asyncio.Handle | None = None
        self._unshown: set[str] = set()  # those that may have changed since the last event
        self._echoes: dict[str, asyncio.Task[None]] = {}  # topics that may not show the state
        self._held_by_others: set[str] = set()  # robots that only others hold, such as an emergency stop
        self._closing = False
        if self._latches.held:
            log.warning(
                "a stop is latched for %s; goals are refused until it is released",
                ", ".join(sorted(self._latches.held)),
            )

    # ------------------------------------------------------------------ queries

    def holds(self, name: str) -> bool:
        """Return whether a stop holds for a namespace or an action."""
        return self._latches.over(name) is not None

    def requested_by(self, name: str) -> str | None:
        """Return who requested the stop that holds for a namespace or an action, if known."""
        over = self._latches.over(name)
        return None if over is None else self._latches.held[over].by

    def require_released(self, name: str, what: str = "goals") -> None:
        """Check that a goal may be sent.

        Args:
            name: The action, or whatever else a robot has on the ROS graph.
            what: What is refused while it is stopped, in the plural.

        Raises:
            Conflict: `stop_latched`.
        """
        over = self._latches.over(name)
        if over is not None:
            by = self._latches.held[over].by
            detail = f"{over} was stopped{f' by {by}' if by else ''}: {what} are refused until the stop is released"
            raise Conflict(f"{detail} (DELETE /stop)", code="stop_latched")

    @property
    def held(self) -> list[str]:
        """The namespaces that were stopped, sorted."""
        return sorted(self._latches.held)

    @property
    def settled(self) -> bool:
        """Whether each topic shows the state, so that nothing is to be published again."""
        return not self._echoes

    def document(self, namespace: str) -> dict[str, Any]:
        """Return the latch of a robot, as `GET /stop` shows it. The robot may have left in the meantime."""
        if self._documents is None:
            self._documents = self._make_documents({ALL_ROBOTS, *self._topics, *self._latches.held})
        return self._documents.get(namespace) or self._make_documents({namespace})[namespace]

    def _make_documents(self, names: set[str]) -> dict[str, dict[str, Any]]:
        persisted = self._writer.problem is None
        documents = self._latches.documents(names, self._places)
        return {name: document | {"persisted": persisted} for name, document in documents.items()}

    def shown(self, namespace: str) -> dict[str, Any]:
        """Return the latch of a joined robot, as last published to subscribers; cheaper than `document`."""
        return self._shown[namespace]

    # ------------------------------------------------------------------ changes

    def join(self, namespace: str, topic: LatchTopic, *, robot: bool = True) -> None:
        """Add a robot. If a gateway's stop holds for it, the stop is published on its topic.

        Args:
            namespace: The robot.
            topic: Its topic.
            robot: Whether there is a robot of this name, or only some below it.
        """
        self._topics[namespace] = topic
        (self._places.discard if robot else self._places.add)(namespace)
        over = self._stopped_at(namespace)
        if over is not None:
            self._latches.latch(namespace, self._latches.held[over])
            self._echo(namespace)
        self._show_soon()
        self._shown[namespace] = self.document(namespace)

    def leave(self, namespace: str) -> None:
        """Remove a robot that is not held."""
        for known in (
            self._topics,
            self._shown,
            self._published,
            self._unpublished,
            self._published_at,
            self._stop_published_at,
        ):
            known.pop(namespace, None)
        if namespace == ALL_ROBOTS:
            self._places.add(namespace)
        self._documents = None
        if (echo := self._echoes.pop(namespace, None)) is not None:
            echo.cancel()

    def latch(self, namespace: str, by: str | None = None) -> None:
        """Refuse goals for a robot and those below it from now on. `publish` makes it known."""
        self._held_by_others.difference_update(self._below(namespace))
        latch = Latch(utc_now(), by)
        names = self._below(namespace)
        self._begin_change(names)
        # Also of robots that are held: a release of the earlier stop may be under way.
        self._stop_published_at.update(dict.fromkeys(names, math.inf))
        new = [name for name in names if self._latches.latch(name, latch) or self._latches.renew(name)]
        if new:
            log.warning("a stop of %s is latched%s", namespace, f" by {by}" if by else "")
            self._changed()

    async def release(self, namespace: str) -> None:
        """Release the stop of a robot and those below it.

        Of a stop of all robots, all else stays stopped until the last robot is released.

        Raises:
            Conflict: `stop_latched`: a stop of a robot above, or another node, holds it.
        """
        for name in self._joined_below(namespace):
            if (by := self._topics[name].held_by()) is not None:
                raise Conflict(f"{by} holds {name} stopped: release it there", code="stop_latched")
        over = self._latches.over(namespace)
        self._begin_change([*self._below(namespace), over or namespace])
        if over is not None and not is_under(over, namespace):
            if over not in self._places:
                raise Conflict(f"the stop of {over} holds for {namespace}, too: release that", code="stop_latched")
            self._latches.release_of(over, namespace)
        for name in self._joined_below(namespace):
            self._topics[name].let_go()
        held = [name for name in self._below(namespace) if self._let_go(name)]
        robots = {*self._topics, *self._latches.held} - self._places
        if over in self._places and not any(self._latches.over(name) == over for name in robots):
            held += [over] * self._let_go(over)
        if held:
            log.warning("the stop of %s is released", namespace)
            self._changed()
        self.publish(over if over in held else namespace)
        await self._writer.wait(STORE_WITHIN)

    async def stored(self, timeout: float) -> Unavailable | None:
        """Wait until the latches are on disk. If they are not within `timeout` seconds, return the reason."""
        if await self._writer.wait(timeout):
            return None
        detail = f"the robot is stopped, but a restart of the gateway would lose the stop: {self._writer.problem}"
        return Unavailable(f"{detail}; the gateway retries until it is stored", code="stop_not_persisted")

    def publish(self, namespace: str) -> None:
        """Publish the state of a robot and of those below it on their topics. A failed publish is retried.

        Each stop is published. Otherwise, an unchanged state is published at most about once per second.
        """
        now = time.monotonic()
        for name in self._joined_below(namespace):
            if stopped := self._stop_published_at.get(name) == math.inf:
                self._stop_published_at[name] = now
            latched = self._stopped_at(name) is not None
            news = stopped or self._published.get(name) is not latched or name in self._echoes
            if (news or now - self._published_at[name] > self._publish_again_after) and not self._publish_to(name):
                self._echo(name)

    def _publish_to(self, namespace: str) -> bool:
        latched = self._stopped_at(namespace) is not None
        self._published_at[namespace] = time.monotonic()
        try:
            self._topics[namespace].publish(latched=latched)
        except Exception as error:
            reason = f"{error}" or repr(error)
            if self._unpublished.get(namespace) != reason:
                log.exception("stop_latched of %s could not be published; retrying", namespace)
            self._unpublished[namespace] = reason
            self._published[namespace] = None
            return False
        self._published[namespace] = latched
        self._unpublished.pop(namespace, None)
        return True

    def unpublished(self, namespace: str) -> dict[str, str]:
        """Return the robots, of one and those below it, whose nodes do not know of their stop or release, and why."""
        return {name: self._unpublished[name] for name in self._below(namespace) if name in self._unpublished}

    def _stopped_at(self, namespace: str) -> str | None:
        """Return the namespace nearest to the root whose stop by a gateway holds for a robot: the one to publish."""
        return self._latches.over(namespace, self._held_by_others)

    def _below(self, namespace: str) -> list[str]:
        """Return a robot and those below it that have joined or are held."""
        names = {namespace, *self._topics, *self._latches.held}
        return sorted(name for name in names if is_under(name, namespace))

    def _joined_below(self, namespace: str) -> list[str]:
        """Return a robot and those below it that have joined."""
        return [name for name in self._below(namespace) if name in self._topics]

    # ------------------------------------------------------------------ messages from other gateways

    def heard(self, namespace: str, *, latched: bool, received: float) -> None:
        """Handle another gateway's latch or release of a robot.

        Args:
            namespace: The robot.
            latched: Whether it was latched or released.
            received: When the message arrived, on the monotonic clock. A release that arrived before our stop was
                published cannot refer to it.
        """
        if latched:
            self._held_by_others.discard(namespace)
        if self._closing or latched == (namespace in self._latches.held):
            return
        if not latched and namespace in self._topics and self._topics[namespace].held_by() is not None:
            return
        if not latched and received <= self._stop_published_at.get(namespace, -math.inf):
            return
        self._begin_change([namespace])
        log.warning("another gateway %s the stop of %s", "latched" if latched else "released", namespace)
        if latched:
            self._latches.latch(namespace, Latch(utc_now()))
        else:
            self._let_go(namespace)
        self._changed()
        self._echo(namespace)
        if latched:
            self.on_heard(namespace)

    def held_by_another(self, namespace: str, by: str | None) -> None:
        """Hold a robot while another node, such as an emergency stop, wants it.

        That node is heard by the robot itself, so nothing is published. A stop from here holds on after it.

        Args:
            namespace: The robot.
            by: The node; None when none wants it any longer.
        """
        if self._closing:
            return
        self._begin_change([namespace])
        if by is not None and self._latches.latch(namespace, Latch(utc_now(), by)):
            log.warning("%s holds %s stopped", by, namespace)
            self._held_by_others.add(namespace)
            self.on_latch(namespace)
            self._changed()
        elif by is not None:
            if namespace in self._held_by_others and self._latches.rename(namespace, by):
                self._changed()
        elif namespace in self._held_by_others:
            log.warning("%s is no longer held stopped", namespace)
            self._let_go(namespace)
            self._changed()

    def _let_go(self, namespace: str) -> bool:
        self._held_by_others.discard(namespace)
        self._stop_published_at.pop(namespace, None)
        released = self._latches.release(namespace)
        if released:
            self.on_release(namespace)
        return released

    def _echo(self, namespace: str) -> None:
        if (before := self._echoes.pop(namespace, None)) is not None:
            before.cancel()
        self._echoes[namespace] = asyncio.create_task(self._echo_later(namespace))

    async def _echo_later(self, namespace: str) -> None:
        while True:
            await asyncio.sleep(self._echo_after)
            try:
                if await self._settle(namespace):
                    del self._echoes[namespace]
                    return
            except Exception:
                log.exception("stop_latched of %s may be out of date; retrying", namespace)

    async def _settle(self, namespace: str) -> bool:
        """Make the topic show the current state; return True once it does.

        Only a stop is repeated, so if the messages of two gateways cross, the stop wins. So does a stop of a namespace
        above, which a gateway that released the robot may not know.
        """
        over, published = self._stopped_at(namespace), self._published.get(namespace, False)
        if over is not None and self._latches.latch(namespace, self._latches.held[over]):
            log.warning("the stop of %s holds for %s, too: publishing it again", over, namespace)
            self._changed()
        elif published is (over is not None):
            return True
        elif published and over is None:
            self._published[namespace] = None
            await self._topics[namespace].withdraw()
            self._published[namespace] = False
            return False  # a stop may have been latched meanwhile
        if over is not None:
            self.on_latch(namespace)
        return self._publish_to(namespace)

    # ------------------------------------------------------------------ storing and notifying

    def _begin_change(self, names: Collection[str]) -> None:
        """Send the events of earlier stops and releases of these robots first: each has one."""
        if self._showing is not None and not self._unshown.isdisjoint(names):
            self._show()
        self._unshown.update(names)

    def _changed(self) -> None:
        self._show_soon()
        self._writer.put(self._latches.held)

    def _show_soon(self) -> None:
        """Notify subscribers in a later iteration of the event loop, so that the stop does not wait for them."""
        self._documents = None
        if self._showing is None:
            self._showing = asyncio.get_running_loop().call_soon(self._show)

    def _show(self) -> None:
        if self._showing is not None:
            self._showing.cancel()
            self._showing = None
        self._unshown.clear()
        for namespace in self._topics:
            document = self.document(namespace)
            if document != self._shown.get(namespace):
                self._shown[namespace] = document
                self._fanout.publish(stop_event(document, self._fanout.clock.stamp(time.time_ns()), robot=namespace))

    async def close(self) -> None:
        """Store unsaved changes, unless the disk hangs."""
        self._closing = True
        await cancel(*self._echoes.values())
        await self._writer.close()
