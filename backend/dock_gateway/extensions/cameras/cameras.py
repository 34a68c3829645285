"""The cameras of all robots. The gateway subscribes to a camera only while someone watches it."""

import asyncio
from collections.abc import AsyncGenerator, AsyncIterator
from contextlib import asynccontextmanager
from http import HTTPStatus

from dock_gateway.core.errors import GatewayError, NotFound, Unavailable, not_covered
from dock_gateway.core.fanout import Fanout, Subscriber
from dock_gateway.core.grant import UNLIMITED, Grant
from dock_gateway.core.request import slot
from dock_gateway.core.tasks import Tasks
from dock_gateway.extensions.cameras.camera import COMPRESSED, IMAGE, Camera, Form, find_cameras
from dock_gateway.extensions.cameras.picture import Picture
from dock_gateway.extensions.cameras.settings import CameraSettings
from dock_gateway.extensions.cameras.watch import Watch
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.relays import Relays
from dock_gateway.robots.registry import RobotRegistry

# Seconds that a viewer waits for its first picture.
FIRST = 5.0
# Pictures that cannot be shown, after which a viewer waits no longer.
UNREADABLE = 3
# Seconds between two checks of a viewer that is not woken up.
LONG = 60.0


class Cameras:
    """Finds the cameras of robots, and watches them for viewers.

    Args:
        settings: Limits of rate and size.
        fanout: Says when the gateway closes.
        robots: The robots.
        graph: Knows the topics.
        relays: Reads the topics.
        first: See `FIRST`.
    """

    def __init__(
        self,
        settings: CameraSettings,
        fanout: Fanout,
        robots: RobotRegistry,
        graph: GraphCache,
        relays: Relays,
        *,
        first: float = FIRST,
    ) -> None:
        self._settings = settings
        self._fanout = fanout
        self._robots = robots
        self._graph = graph
        self._relays = relays
        self._first = first
        self._watches: dict[tuple[str, ...], Watch] = {}
        self._logged: dict[str, str] = {}
        self._changing = asyncio.Lock()
        self._leaving = Tasks("leaving a camera")

    async def all(self, robot: str | None, grant: Grant) -> list[Camera]:
        """Return the cameras of a robot that a grant includes.

        Raises:
            NotFound: There is no such robot.
            Unavailable: `ros_unavailable`, when the ROS thread is down.
        """
        robot = self._robots.get(robot).namespace
        topics = await self._graph.topics_of((IMAGE, COMPRESSED), robot)

        def belongs(topic: str) -> bool:
            owner = self._robots.owner(topic)
            return owner is not None and owner.namespace == robot and grant.covers_topic(topic)

        return find_cameras(robot, topics, belongs)

    async def find(self, robot: str | None, name: str, grant: Grant) -> Camera:
        """Return a camera of a robot.

        Raises:
            NotAllowed: The grant does not include it (`not_allowed`).
            NotFound: The robot has none of this name (`camera_not_found`), or there is no such robot.
            Unavailable: `ros_unavailable`, when the ROS thread is down.
        """
        for camera in await self.all(robot, grant):
            if camera.name == name:
                return camera
        others = await self.all(robot, UNLIMITED)
        if any(camera.name == name for camera in others):
            raise not_covered(f"the camera {name[:100]}")
        raise NotFound(
            f"the robot {self._robots.get(robot).namespace} has no camera {name[:100]}", code="camera_not_found"
        )

    def hint(self, camera: Camera) -> str | None:
        """Return why the pictures of a camera that is being watched cannot be shown; None if they can."""
        watch = self._watches.get(camera.topics)
        return None if watch is None else watch.hint

    def form(self, camera: Camera) -> Form:
        """Return the form that a camera's pictures come in now; without viewers, the one that is tried first."""
        watch = self._watches.get(camera.topics)
        topic = camera.topics[0] if watch is None else watch.forms.topic
        return next(form for form in camera.forms if form.topic == topic)

    async def pictures(
        self, camera: Camera, viewer: Subscriber, max_width: int | None, max_rate: float | None
    ) -> AsyncGenerator[Picture]:
        """Yield the newest picture each time that the viewer takes one, until it may no longer read.

        Args:
            camera: The camera.
            viewer: Is woken up by each picture. It may be used for nothing else.
            max_width: Width in pixels; at most that of the settings.
            max_rate: Maximum pictures per second.

        Raises:
            TooManyRequests: The user watches too many cameras, or all users together.
            Unavailable: No picture has come (`picture_unavailable`).
            GatewayError: None has come that can be shown (`unreadable_picture`).
        """
        width = min(max_width or self._settings.camera_max_width, self._settings.camera_max_width)
        rate = min(max_rate or self._settings.camera_max_rate, self._settings.camera_max_rate)
        loop = asyncio.get_running_loop()
        async with self._watched(camera, viewer) as watch:
            seen = watch.count if watch.newest is None or watch.newest.stale else -1
            shown, failed, due, until = False, 0, 0.0, loop.time() + self._first
            while not (self._fanout.closing or viewer.expelled):
                now = loop.time()
                if not shown and (now >= until or (failed >= UNREADABLE and len(camera.forms) == 1)):
                    raise _nothing_to_show(watch, self._first)
                if watch.count == seen:
                    await viewer.take(LONG if shown else until - now)
                elif due > now:
                    await viewer.take(due - now)
                else:
                    due, seen = max(due, now - 1 / rate) + 1 / rate, watch.count
                    if (picture := await watch.picture(width)) is None:
                        failed += 1
                    elif not viewer.expelled:
                        shown = True
                        yield picture

    @asynccontextmanager
    async def _watched(self, camera: Camera, viewer: Subscriber) -> AsyncIterator[Watch]:
        """Watch a camera for a viewer while the block runs."""
        with slot("cameras", camera.topics[0]):
            async with self._changing:
                watch = self._watches.get(camera.topics) or await self._open(camera)
                watch.viewers.add(viewer)
            try:
                yield watch
            finally:
                watch.viewers.discard(viewer)
                # A viewer that disconnects is canceled at each of its awaits.
                await asyncio.shield(self._leaving.spawn(self._close_unused(watch)))

    async def _close_unused(self, watch: Watch) -> None:
        topics = watch.camera.topics
        async with self._changing:
            if not watch.viewers and self._watches.get(topics) is watch:
                del self._watches[topics]
                await watch.forms.close()

    async def _open(self, camera: Camera) -> Watch:
        watch = Watch(camera, self._relays, self._settings.camera_quality, self._logged)
        await watch.forms.open()
        self._watches[camera.topics] = watch
        return watch

    async def close(self) -> None:
        """Leave no task behind."""
        await self._leaving.close()


def _nothing_to_show(watch: Watch, waited: float) -> GatewayError:
    if watch.hint is not None:
        detail = f"{watch.forms.topic} cannot be shown: {watch.hint}"
        return GatewayError(detail, code="unreadable_picture", status=HTTPStatus.BAD_GATEWAY)
    topics = " or ".join(watch.camera.topics)
    return Unavailable(f"no picture has come on {topics} within {waited:g} s", code="picture_unavailable")
