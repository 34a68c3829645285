"""rosbridge-server-rs: rosbridge's protocol over WebSocket, in Rust."""

import asyncio
import sysconfig
import tempfile
import time
from pathlib import Path
from typing import Any

import orjson
from picows import WSMsgType
from tests.support.processes import Process

from benchmarks.http import free_port
from benchmarks.readers import Tally, WebSocketReader, connect
from benchmarks.site import ACTION, ACTION_TYPE, Goal, Site, site_packages
from benchmarks.systems.base import Impossible, Reading, System, Timing

START_TIMEOUT = 10.0
MARK = b'"op":"publish"'


class Rosbridge(System):
    """The peer.

    Args:
        where: Where to start it.
        prefix: Its Python environment, which brings ROS's libraries.
    """

    name = "rosbridge-server-rs"

    def __init__(self, where: Site, prefix: Path) -> None:
        super().__init__(where)
        self._prefix = prefix
        self.port = free_port()

    async def start(self) -> None:
        """Start it and have a first goal end."""
        binary = site_packages(self._prefix) / "rosbridge_server_rs/rosbridge_server_rs_jazzy"
        if not binary.is_file():
            raise Impossible("not installed")
        self._folder = tempfile.TemporaryDirectory()
        library = Path(self._folder.name) / "librmw_implementation.so"
        library.symlink_to((self._prefix / "lib/librmw_fastrtps_cpp.so").resolve())
        libpython = f"{sysconfig.get_config_var('LIBDIR')}/{sysconfig.get_config_var('INSTSONAME')}"
        # What PyPI's wheels do for Python programs alone: let the loader find their libraries.
        folders = [self._folder.name, self._prefix / "lib", *site_packages(self._prefix).glob("*.libs")]
        environment = self.site.environment(
            self._prefix,
            LD_LIBRARY_PATH=":".join(map(str, folders)),
            LD_PRELOAD=libpython,
            ROS_DISTRO="jazzy",
        )
        command = (str(binary), "--bind", f"127.0.0.1:{self.port}", "--log-directory", self._folder.name, "--no-rosapi")
        self.process = Process(*command, env=environment).__enter__()
        await self._until_answered()

    async def _until_answered(self) -> None:
        deadline = time.monotonic() + START_TIMEOUT
        while time.monotonic() < deadline and self.process.running:
            try:
                await self._open()
                break
            except OSError:
                await asyncio.sleep(0.02)
        else:
            raise Impossible(f"it did not start: {self.process.output[:300]}")
        for _ in range(self.patience):
            try:
                await self._goal(Goal(), START_TIMEOUT / 2)
            except TimeoutError:
                continue
            return
        raise Impossible(f"the first goal was never answered ({START_TIMEOUT / 2:g} s)")

    async def _open(self) -> None:
        self._results: dict[str, asyncio.Future[None]] = {}
        self._transport, _ = await connect(self._url, lambda: WebSocketReader(Tally(), b"\0", self._hear))

    @property
    def _url(self) -> str:
        return f"ws://127.0.0.1:{self.port}"

    def _hear(self, text: bytes) -> None:
        message = orjson.loads(text)
        waiting = self._results.pop(message.get("id", ""), None)
        if message.get("op") == "action_result" and waiting and not waiting.done():
            waiting.set_result(None)

    def _send_goal(self, goal: Goal) -> asyncio.Future[None]:
        identity = f"goal-{time.monotonic_ns()}"
        self._results[identity] = asyncio.get_running_loop().create_future()
        args = {"desired_battery_state": goal.state}
        order = {"op": "send_action_goal", "id": identity, "action": f"/{ACTION}", "action_type": ACTION_TYPE}
        _send(self._transport, {**order, "args": args, "feedback": False})
        return self._results[identity]

    async def _goal(self, goal: Goal, timeout: float = 60.0) -> None:
        await asyncio.wait_for(self._send_goal(goal), timeout)

    async def submit(self) -> Timing:
        """One goal to its result; the protocol has no acceptance."""
        start = time.perf_counter()
        await self._goal(Goal())
        return Timing(None, (time.perf_counter() - start) * 1e3)

    async def stream(self, goal: Goal, readers: int) -> Reading:
        """Subscribe to the action's feedback topic."""
        tally = Tally()
        order = {"op": "subscribe", "topic": f"/{ACTION}/_action/feedback", "type": f"{ACTION_TYPE}_FeedbackMessage"}
        connections = []
        try:
            for _ in range(readers):
                connections.append(await connect(self._url, lambda: WebSocketReader(tally, MARK)))
                _send(connections[-1][0], order)
            await asyncio.sleep(1.0 + readers / 500)
            done = self._send_goal(goal)
            cpu = await self.cpu_during(goal.seconds, goal.delay)
            await tally.settle(goal.count * readers)
            await asyncio.wait_for(done, 30)
        finally:
            for transport, _ in connections:
                transport.disconnect()
        return Reading.of(goal.count * readers, list(tally.latencies), list(tally.stamps), cpu)

    async def close(self) -> None:
        """End it."""
        if hasattr(self, "process"):
            await super().close()
            self._folder.cleanup()


def _send(transport: Any, order: dict[str, Any]) -> None:
    transport.send(WSMsgType.TEXT, orjson.dumps(order))
