"""rosbridge-server-rs and rosbridge_suite: rosbridge's protocol over WebSocket, in Rust and in Python."""

import asyncio
import sysconfig
import tempfile
import time
from pathlib import Path
from typing import Any

import orjson
from picows import WSMsgType, WSTransport
from tests.support.processes import Process, free_port

from benchmarks.figures import ROSBRIDGE, ROSBRIDGE_SUITE
from benchmarks.readers import Tally, WebSocketReader, connect
from benchmarks.site import ACTION, ACTION_TYPE, Goal, Site, site_packages
from benchmarks.systems.base import Impossible, Reading, System, Timing

START_TIMEOUT = 60.0
ANSWER_TIMEOUT = 10.0
MARK = b'"op":"publish"'
# Without a type: the server takes it from the ROS graph, and refuses the name of an action's own message types.
# The depth is the one that the gateway uses.
SUBSCRIBE = {
    "op": "subscribe",
    "id": "subscribe",
    "topic": f"/{ACTION}/_action/feedback",
    "qos": {"history": "keep_last", "depth": 1000, "reliability": "reliable", "durability": "volatile"},
}
# A subscription is answered only if it fails. An operation that does not exist is always answered, and in turn.
BARRIER = {"op": "barrier", "id": "barrier"}


class Rosbridge(System):
    """The peer.

    Args:
        where: Where to start it.
        prefix: Its Python environment, which brings ROS's libraries.
    """

    name = ROSBRIDGE

    def __init__(self, where: Site, prefix: Path) -> None:
        super().__init__(where)
        self._prefix = prefix
        self._results: dict[str, asyncio.Future[None]] = {}

    async def start(self) -> None:
        """Start it and have a first goal end."""
        binary = site_packages(self._prefix) / "rosbridge_server_rs/rosbridge_server_rs_jazzy"
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
        address = f"127.0.0.1:{free_port()}"
        self.rosbridge_url = f"ws://{address}"
        command = (str(binary), "--bind", address, "--log-directory", self._folder.name, "--no-rosapi")
        self.process = Process(*command, env=environment).__enter__()
        await self._until_subscribed()
        self._transport, _ = await connect(self.rosbridge_url, lambda: WebSocketReader(Tally(), b"\0", self._hear))
        await self._goal(Goal())

    async def _until_subscribed(self) -> None:
        """Wait until it has found the action: a goal that is sent before is lost."""
        deadline, why = time.monotonic() + START_TIMEOUT, "it ended"
        while time.monotonic() < deadline and self.process.running:
            try:
                (await self._subscribe(Tally())).disconnect()
            except (OSError, Impossible) as error:
                why = str(error)
                await asyncio.sleep(0.02)
            else:
                return
        raise Impossible(f"{why}: {self.process.output[-300:]}")

    async def _subscribe(self, tally: Tally) -> WSTransport:
        """Open a connection that reads the feedback, and return when the server has subscribed."""
        answers: asyncio.Queue[bytes] = asyncio.Queue()
        transport, _ = await connect(self.rosbridge_url, lambda: WebSocketReader(tally, MARK, answers.put_nowait))
        _send(transport, SUBSCRIBE)
        _send(transport, BARRIER)
        answer = orjson.loads(await asyncio.wait_for(answers.get(), ANSWER_TIMEOUT))
        if answer.get("id") != BARRIER["id"]:
            transport.disconnect()
            raise Impossible(answer["msg"])
        return transport

    def _hear(self, text: bytes) -> None:
        message = orjson.loads(text)
        waiting = self._results.pop(message.get("id", ""), None)
        if message.get("op") != "action_result" or waiting is None or waiting.done():
            return
        if message["result"]:
            waiting.set_result(None)
        else:
            waiting.set_exception(Impossible(f"goal failed: {message['values']}"))

    def _send_goal(self, goal: Goal) -> asyncio.Future[None]:
        identity = f"goal-{time.monotonic_ns()}"
        self._results[identity] = asyncio.get_running_loop().create_future()
        args = {"desired_battery_state": goal.state}
        order = {"op": "send_action_goal", "id": identity, "action": f"/{ACTION}", "action_type": ACTION_TYPE}
        _send(self._transport, {**order, "args": args, "feedback": False})
        return self._results[identity]

    async def _goal(self, goal: Goal) -> None:
        await asyncio.wait_for(self._send_goal(goal), ANSWER_TIMEOUT)

    async def submit(self) -> Timing:
        """One goal to its result; the protocol has no acceptance."""
        start = time.perf_counter()
        await self._goal(Goal())
        return Timing(None, (time.perf_counter() - start) * 1e3)

    async def stream(self, goal: Goal, readers: int) -> Reading:
        """Subscribe to the action's feedback topic."""
        tally = Tally()
        transports: list[WSTransport] = []
        try:
            while len(transports) < readers:
                transports.append(await self._subscribe(tally))
            done = self._send_goal(goal)
            cpu = await self.cpu_during(goal.seconds, goal.delay)
            await tally.settle(goal.count * readers)
            await asyncio.wait_for(done, 30)
        finally:
            for transport in transports:
                transport.disconnect()
        return Reading.of(goal.count * readers, list(tally.latencies), list(tally.stamps), cpu)

    async def close(self) -> None:
        """End it."""
        if hasattr(self, "process"):
            await super().close()
            self._folder.cleanup()


class RosbridgeSuite(Rosbridge):
    """rosbridge_suite. It is on no registry: its environment is made by hand, as docs/performance.md says."""

    name = ROSBRIDGE_SUITE

    async def start(self) -> None:
        """Start it and have a first goal end."""
        self._folder = tempfile.TemporaryDirectory()
        port, programs = free_port(), self._prefix / "bin"
        self.rosbridge_url = f"ws://127.0.0.1:{port}"
        command = (str(programs / "python"), str(programs / "rosbridge_websocket"), "--port", str(port))
        self.process = Process(*command, env=self.site.environment(self._prefix)).__enter__()
        deadline = time.monotonic() + START_TIMEOUT
        while True:
            try:
                self._transport, _ = await connect(
                    self.rosbridge_url, lambda: WebSocketReader(Tally(), b"\0", self._hear)
                )
            except OSError as error:
                if time.monotonic() > deadline or not self.process.running:
                    raise Impossible(f"{error}: {self.process.output[-300:]}") from error
                await asyncio.sleep(0.1)
            else:
                break
        await self._goal(Goal())


def _send(transport: Any, order: dict[str, Any]) -> None:
    transport.send(WSMsgType.TEXT, orjson.dumps(order))
