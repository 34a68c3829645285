"""The black box: hears every robot all the time, and writes a file of each goal while it runs.

A goal that has succeeded before the first piece is due costs no file: nothing is to be kept of it.
"""

import asyncio
import logging
import time
from contextlib import suppress

from dock_gateway.core.audit import AuditEntry
from dock_gateway.core.event import utc_now
from dock_gateway.core.filters import is_under
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.core.tasks import Tasks
from dock_gateway.extensions.recordings.collector import RobotCollector
from dock_gateway.extensions.recordings.ring import Ring
from dock_gateway.extensions.recordings.server_parameters import PAUSE, ServerParameters
from dock_gateway.extensions.recordings.settings import RecordingSettings
from dock_gateway.extensions.recordings.store import OpenRecording, RecordingStore
from dock_gateway.extensions.recordings.topics import CAMERA, RecordedTopic, recorded_topics
from dock_gateway.graph.relays import Relays
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.graph import Scan
from dock_gateway.settings import Settings
from robot_io.recording import Sample

log = logging.getLogger(__name__)

# Seconds before the start of a goal that its recording has.
BEFORE_GOAL = 5.0
# Seconds after the end of a goal that its recording has.
AFTER_GOAL = 2.0
# Seconds between two writes to a recording.
FLUSH_INTERVAL = 0.5
# Seconds between two deletions of what is too much.
CLEAN_INTERVAL = 60.0
# Seconds that the end of the gateway waits for the disk.
CLOSE_TIMEOUT = 2.0
# Bytes of a file, as it is on the disk, after which only the end of the recording is written.
MAX_FILE_BYTES = 200_000_000
# The same for the bytes before they are compressed.
MAX_UNCOMPRESSED_BYTES = 1_000_000_000


class _Running:
    """A goal that is being recorded.

    Attributes:
        seen: Number of the last message in the ring that is not to be written any more; None: nothing is due yet.
    """

    def __init__(self, goal: Goal, robot: str, collector: RobotCollector) -> None:
        self.goal = goal
        self.robot = robot
        self.collector = collector
        self.ends_at: float | None = None
        self.began_at = time.monotonic()
        self.began_ns = time.time_ns() - int(BEFORE_GOAL * 1e9)
        self.seen: int | None = None
        self.state: object = None
        self.opened: OpenRecording | None = None
        self.elsewhere = False  # another gateway on this machine records it in the same folder

    @property
    def full(self) -> bool:
        """Whether only the end is still to be written."""
        opened = self.opened
        return opened is not None and (
            opened.size > MAX_FILE_BYTES or opened.file.uncompressed_bytes > MAX_UNCOMPRESSED_BYTES
        )

    def about(self) -> dict[str, str]:
        """Return what the recording is about."""
        goal = self.goal
        error = "" if goal.error is None else f"{goal.error.code}: {goal.error.detail}"
        return {
            "goal_id": goal.goal_id,
            "robot": self.robot,
            "action_name": goal.action_name,
            "action_type": goal.action_type,
            "status": goal.status.value,
            "error": error,
        }


class Recorder:
    """Records the goals of all robots.

    Args:
        settings: Name topics; those of recordings say what is recorded, and how much of it is kept.
        bridge: The bridge to the ROS thread.
        relays: The topics.
        robots: The robots.
        store: Keeps the files.
    """

    def __init__(
        self, settings: Settings, bridge: Bridge, relays: Relays, robots: RobotRegistry, store: RecordingStore
    ) -> None:
        self._names, self._settings = settings, settings.of(RecordingSettings)
        self._relays = relays
        self._parameters = ServerParameters(bridge, relays)
        self._robots = robots
        self._store = store
        self._collectors: dict[str, RobotCollector] = {}
        self._running: dict[str, _Running] = {}
        self._scan = Scan()
        self._changed = asyncio.Event()
        self._choosing = asyncio.Lock()
        self._closing = asyncio.Event()
        self._since = utc_now()
        self._tasks = Tasks("recording")
        self._tasks.spawn(self._follow_topics())
        self._writing = self._tasks.spawn(self._write_on())

    # ------------------------------------------------------------------ topics

    def update(self, scan: Scan) -> None:
        """Follow what is on the ROS graph."""
        self._scan = scan
        self._parameters.keep(scan.actions)
        self._changed.set()

    async def _follow_topics(self) -> None:
        while True:
            await self._changed.wait()
            self._changed.clear()
            try:
                async with self._choosing:
                    await self._choose_topics()
            except Exception:
                log.exception("while choosing the topics to record")

    async def leave(self, robot: str) -> None:
        """Leave the topics of a robot that is about to be removed."""
        async with self._choosing:
            if (collector := self._collectors.pop(robot, None)) is not None:
                await collector.listen(self._relays, {})

    async def _choose_topics(self) -> None:
        """Subscribe to what is to be heard of the robots, and leave the rest."""
        robots = self._robots.namespaces()
        recorded = {running.robot for running in self._running.values()}
        written = {running.robot for running in self._running.values() if running.seen is not None}
        wanted = dict.fromkeys((*recorded.intersection(robots), *robots[: self._settings.recording_buffer_robots]))
        for robot in self._collectors.keys() - wanted.keys() - recorded:
            await self._collectors.pop(robot).listen(self._relays, {})
        for robot in wanted:
            await self._collector(robot).listen(self._relays, self._topics(robot, pictures=robot in written))

    def _topics(self, robot: str, *, pictures: bool) -> dict[str, RecordedTopic]:
        """Return what to listen to. Cameras only where a goal runs: they fill a network, and many rest unless heard."""
        scan, more = self._scan, self._settings.recording_topics
        found = recorded_topics(robot, self._names, scan.topics, scan.actions, self._owner, more=more)
        return {topic: wanted for topic, wanted in found.items() if pictures or wanted.kind != CAMERA}

    def _owner(self, name: str) -> str | None:
        robot = self._robots.owner(name)
        return None if robot is None else robot.namespace

    def _collector(self, robot: str) -> RobotCollector:
        if robot not in self._collectors:
            settings = self._settings
            self._collectors[robot] = RobotCollector(
                Ring(settings.recording_buffer_s, settings.recording_buffer_mb * 1_000_000)
            )
        return self._collectors[robot]

    # ------------------------------------------------------------------ goals

    def follow(self, goal: Goal) -> None:
        """Record a goal that has been sent or has changed."""
        if goal.status.terminal:
            self.end(goal)
            return
        if (running := self._running.get(goal.goal_id)) is None:
            robot = self._robots.owner(goal.action_name)
            if robot is None:
                self._store.note(goal.goal_id, "Its action belongs to no robot.")
                return
            if robot.namespace not in self._collectors:
                self._changed.set()
            running = _Running(goal, robot.namespace, self._collector(robot.namespace))
            self._running[goal.goal_id] = running
        running.ends_at = None
        self._note_state(running)

    def end(self, goal: Goal) -> None:
        """End the recording of a goal soon: it has ended, or is lost. One that nothing was written of ends at once."""
        running = self._running.get(goal.goal_id)
        if running is None or running.ends_at is not None:
            return
        self._note_state(running)
        reason = self._unwanted(goal)
        # Of one that ran before this process, an earlier one may have left a file.
        if running.seen is None and reason is not None and goal.created_at >= self._since:
            self._store.note(goal.goal_id, reason)
            self._stop(running)
        else:
            running.ends_at = time.monotonic() + AFTER_GOAL

    def _unwanted(self, goal: Goal) -> str | None:
        """Return why nothing is kept of a goal that has ended; None: it is kept."""
        if goal.unsent:
            return "The goal was not sent to the action server."
        if goal.status is GoalStatus.REJECTED:
            return "The action server did not accept the goal."
        if goal.status is GoalStatus.SUCCEEDED and self._settings.recordings != "all":
            return "The goal succeeded, and only others are kept (`--recordings all`)."
        return None

    async def _note_parameters(self, running: _Running) -> None:
        """Keep the parameters of the goal's server: by them its decisions can be replayed."""
        goal = running.goal
        while True:  # a busy server may not answer at once
            if (parameters := await self._parameters.read(goal.action_name)) is not None:
                running.collector.note({"type": "parameters", "goal_id": goal.goal_id, **parameters})
                return
            await asyncio.sleep(PAUSE)
            if running.ends_at is not None:
                return

    @staticmethod
    def _note_state(running: _Running) -> None:
        goal = running.goal
        state = (goal.status, goal.stage, goal.retries, goal.stalled)
        if state != running.state:
            running.state = state
            document = {"type": "status", "time": goal.updated_at, **goal.state()}
            document |= {"goal": None} if goal.goal is None else {"goal": goal.summary()["goal"]}
            running.collector.note(document)

    def on_command(self, entry: AuditEntry) -> None:
        """Keep what someone has commanded: who, what, for which robot."""
        robots = (entry.robot or "").split(",")
        owner = None if entry.action_name is None else self._owner(entry.action_name)
        for name, collector in self._collectors.items():
            if name == owner or any(robot and is_under(name, robot) for robot in robots):
                collector.note(
                    {
                        "type": "command",
                        "time": entry.acted_at,
                        "what": entry.what,
                        "by": entry.principal,
                        "role": entry.role,
                        "robot": entry.robot,
                        "goal_id": entry.goal_id,
                        "subject": entry.subject,
                        "status": entry.status,
                        "code": entry.code,
                    }
                )

    def is_running(self, goal_id: str) -> bool:
        """Return whether a goal is being recorded."""
        return goal_id in self._running

    # ------------------------------------------------------------------ files

    async def _write_on(self) -> None:
        await asyncio.to_thread(self._store.recover)
        clean_at = 0.0
        while not self._closing.is_set():
            for running in list(self._running.values()):
                await self._proceed(running)
            if time.monotonic() >= clean_at:
                clean_at = time.monotonic() + CLEAN_INTERVAL
                await asyncio.to_thread(self._store.clean)
            with suppress(TimeoutError):
                async with asyncio.timeout(FLUSH_INTERVAL):
                    await self._closing.wait()
        for running in list(self._running.values()):
            await self._proceed(running, closing=True)

    async def _proceed(self, running: _Running, *, closing: bool = False) -> None:
        """Write what was heard since the last time, and finish the file if its time has come."""
        ring, age = running.collector.ring, time.monotonic() - running.began_at
        done = running.ends_at is not None and (closing or time.monotonic() >= running.ends_at)
        if running.seen is None:
            if age < FLUSH_INTERVAL and not closing:
                return
            running.seen = ring.mark(BEFORE_GOAL + age)
            self._changed.set()
            self._tasks.spawn(self._note_parameters(running))
        samples: list[Sample] = []
        if not (running.elsewhere or (running.full and not done)):
            samples = ring.after(running.seen)
            if running.opened is None:
                samples = _after_held(ring.held(running.seen), samples, running.began_ns)
            running.seen = ring.heard
        try:
            if not running.elsewhere:
                await asyncio.to_thread(self._write, running, samples, done=done)
        except BlockingIOError:
            running.elsewhere = True
        except OSError as error:
            self._store.complain(error)
            self._give_up(running, "The disk did not take it: it is full, or cannot be written.")
            return
        except Exception:
            log.exception("while recording goal %s", running.goal.goal_id)
            self._give_up(running, "It could not be written; the gateway's log says why.")
            return
        if done:
            self._stop(running)

    def _write(self, running: _Running, samples: list[Sample], *, done: bool) -> None:
        goal_id, goal = running.goal.goal_id, running.goal
        if running.opened is None:
            running.opened = self._store.open(goal_id)
        else:
            self._store.require_room()
        opened = running.opened
        opened.file.write(samples)
        if not done:
            return
        if (reason := self._unwanted(goal)) is not None:
            self._store.forget(opened, goal_id, reason)
        else:
            self._store.finish(opened, goal_id, running.about(), failed=goal.status is not GoalStatus.SUCCEEDED)

    def _give_up(self, running: _Running, reason: str) -> None:
        """Record a goal no more; its next event begins a new file, if there is room again."""
        self._store.note(running.goal.goal_id, reason)
        if running.opened is not None:
            running.opened.drop()
        self._stop(running)

    def _stop(self, running: _Running) -> None:
        self._running.pop(running.goal.goal_id, None)
        if running.seen is not None:
            self._changed.set()

    @property
    def robots(self) -> int:
        """Number of robots that are listened to while no goal runs."""
        return self._settings.recording_buffer_robots

    def heard_of(self, robot: str) -> list[Sample] | None:
        """Return what has been heard of a robot in the last seconds; None if it is not listened to."""
        if (collector := self._collectors.get(robot)) is None:
            return None
        return _after_held(collector.ring.held(0), collector.ring.after(0), time.time_ns())

    async def close(self) -> None:
        """Write what there is of running goals, with which the next process goes on."""
        self._closing.set()
        await asyncio.wait([self._writing], timeout=CLOSE_TIMEOUT)
        await self._tasks.close()
        await self._parameters.close()


def _after_held(held: list[Sample], samples: list[Sample], began_ns: int) -> list[Sample]:
    """Return messages after those that hold at the beginning, so that a player publishes these first."""
    first_ns = min((each.received_ns for each in samples), default=began_ns)
    return [each._replace(received_ns=min(first_ns, began_ns)) for each in held] + samples
