"""dock-gateway, out of this checkout or another one."""

import asyncio
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

import orjson
from tests.support.processes import Process, free_port

from benchmarks.figures import OURS
from benchmarks.http import Connection, KeptConnection
from benchmarks.readers import Tally, WebSocketReader, connect
from benchmarks.site import PRODUCT, Goal, Site
from benchmarks.systems.base import Impossible, Reading, System, Timing

MARK = b'"type":"feedback"'
START_TIMEOUT = 60.0
DISCOVERY = 60.0


class Gateway(System):
    """The gateway as it is started by `dock-gateway serve`.

    Args:
        where: Where to start it.
        variant: Name of another version, and its checkout with the environment that `make setup` made there.
    """

    def __init__(self, where: Site, variant: tuple[str, Path] | None = None) -> None:
        super().__init__(where)
        self.name = f"{OURS} {variant[0]}" if variant else OURS
        self._prefix = variant[1] / ".venv" if variant else PRODUCT
        self._headers: dict[str, str] = {}  # of every request

    async def start(self) -> None:
        """Start it and have a first goal accepted."""
        await self.start_idle()
        await asyncio.to_thread(self._until_accepted)

    async def start_idle(self) -> None:
        """Start it, and come back when it answers HTTP."""
        self.port = free_port()
        self._kept = KeptConnection(self._connection)
        self._data = tempfile.TemporaryDirectory()
        variables = {"XDG_DATA_HOME": self._data.name, "DOCK_GATEWAY_PORT": str(self.port)}
        variables |= {"DOCK_GATEWAY_MAX_SUBSCRIBERS": "2000", "DOCK_GATEWAY_LOG_LEVEL": "warning"}
        environment = self.site.environment(self._prefix, **variables, **await asyncio.to_thread(self._more_settings))
        self.process = Process(str(self._prefix / "bin/dock-gateway"), "serve", env=environment).__enter__()
        await asyncio.to_thread(self._until_listening)

    @property
    def rosbridge_url(self) -> str:
        """Where clients of rosbridge connect."""
        return f"ws://127.0.0.1:{self.port}/rosbridge"

    def _more_settings(self) -> dict[str, str]:
        """Return further settings; prepare what the gateway asks its users for."""
        return {}

    def _connection(self) -> Connection:
        lines = "".join(f"{name}: {value}\r\n" for name, value in self._headers.items())
        return Connection(self.port, headers=lines)

    def _until_listening(self) -> None:
        deadline = time.monotonic() + START_TIMEOUT
        while time.monotonic() < deadline and self.process.running:
            try:
                Connection(self.port).__exit__()
            except OSError:
                time.sleep(0.01)
            else:
                return
        raise Impossible(f"it did not listen within {START_TIMEOUT:g} s: {self.process.output[-600:]}")

    def _until_accepted(self) -> None:
        deadline = time.monotonic() + START_TIMEOUT
        while time.monotonic() < deadline and self.process.running:
            try:
                with self._connection() as connection:
                    if connection.request("POST", "/dock")[0] == 202:
                        return
            except OSError:
                pass
            time.sleep(0.02)
        raise Impossible(f"no goal was accepted within {START_TIMEOUT:g} s: {self.process.output[-600:]}")

    def healthz(self) -> float:
        """One request that does next to nothing, in ms."""
        return self._kept.get().time("GET", "/healthz")

    async def submit(self) -> Timing:
        """One goal to its acceptance, another one to its result."""
        return await asyncio.to_thread(self._submit)

    def _submit(self) -> Timing:
        connection = self._kept.get()
        start = time.perf_counter()
        status, goal = connection.request("POST", "/dock")
        accepted = time.perf_counter() - start
        assert status == 202, goal
        while connection.request("GET", f"/dock/{goal['goal_id']}")[1]["finished_at"] is None:
            time.sleep(0.002)
        start = time.perf_counter()
        status, goal = connection.request("POST", "/dock", headers="Prefer: wait=10\r\n")
        assert status == 200, goal
        return Timing(accepted * 1e3, (time.perf_counter() - start) * 1e3)

    async def one_goal(self) -> None:
        """One goal, with its result, read once."""
        await asyncio.to_thread(self._one_goal)

    def _one_goal(self) -> None:
        connection = self._kept.get()
        status, goal = connection.request("POST", "/dock", headers="Prefer: wait=10\r\n")
        assert status == 200, goal
        status, goal = connection.request("GET", f"/goals/{goal['goal_id']}")
        assert goal["finished_at"] is not None, goal

    async def stream(self, goal: Goal, readers: int) -> Reading:
        """Read /ws/feedback."""
        return await self._read(goal, readers, ["/dock"])

    async def start_robots(self, names: list[str]) -> None:
        """Start it, and come back when it knows each robot's action."""
        await self.start_idle()
        deadline = time.monotonic() + DISCOVERY
        while missing := set(names) - await asyncio.to_thread(self._actions):
            if time.monotonic() > deadline:
                raise Impossible(f"{len(missing)} of {len(names)} actions were unknown after {DISCOVERY:g} s")
            await asyncio.sleep(0.1)

    async def read_robots(self, goal: Goal, names: list[str]) -> Reading:
        """Have each robot's action run a goal and read all feedback."""
        return await self._read(goal, 1, [f"/actions{name}/goals" for name in names])

    async def _read(self, goal: Goal, readers: int, submit_to: list[str]) -> Reading:
        """Have a goal run at each of some addresses, and read all feedback."""
        tally = Tally()
        url = f"ws://127.0.0.1:{self.port}/ws/feedback"
        connections = []
        for first in range(0, readers, 50):
            batch = (
                connect(url, lambda: WebSocketReader(tally, MARK), self._headers)
                for _ in range(first, min(readers, first + 50))
            )
            connections += await asyncio.gather(*batch)
        try:
            await asyncio.wait_for(asyncio.gather(*(reader.begun for _, reader in connections)), 30)
            body: dict[str, Any] = {"desired_battery_state": goal.state}
            await asyncio.to_thread(self._post, submit_to, body)
            cpu = await self.cpu_during(goal.seconds, goal.delay)
            expected = goal.count * readers * len(submit_to)
            await tally.settle(expected)
        finally:
            for transport, _ in connections:
                transport.disconnect()
        return Reading.of(expected, list(tally.latencies), list(tally.stamps), cpu)

    def _post(self, paths: list[str], body: dict[str, Any]) -> None:
        with self._connection() as connection:
            for path in paths:
                status, answer = connection.request("POST", path, body)
                assert status == 202, orjson.dumps(answer).decode()

    def _actions(self) -> set[str]:
        with self._connection() as connection:
            _, answer = connection.request("GET", "/actions")
        return {action["action_name"] for action in answer["actions"] if action["available"]}

    async def close(self) -> None:
        """End it."""
        await super().close()
        self._data.cleanup()


class GatewayWithTokens(Gateway):
    """The gateway with authentication: every request and every stream shows a token."""

    def __init__(self, where: Site) -> None:
        super().__init__(where)
        self.name = f"{OURS} with tokens"

    def _more_settings(self) -> dict[str, str]:
        environment = self.site.environment(self._prefix, XDG_DATA_HOME=self._data.name)
        create = (str(self._prefix / "bin/dock-gateway"), "token", "create", "benchmark", "--role", "admin")
        secret = subprocess.run(create, env=environment, check=True, capture_output=True, text=True).stdout.strip()
        self._headers = {"Authorization": f"Bearer {secret}"}
        limits = {"DOCK_GATEWAY_MAX_STREAMS_PER_USER": "2000", "DOCK_GATEWAY_MAX_GOALS_PER_MINUTE": "10000"}
        return {"DOCK_GATEWAY_AUTHENTICATION": "true", **limits}


class GatewayInMemory(Gateway):
    """The gateway without a database."""

    def __init__(self, where: Site) -> None:
        super().__init__(where)
        self.name = f"{OURS} with memory:"

    def _more_settings(self) -> dict[str, str]:
        return {"DOCK_GATEWAY_DATABASE_URL": "memory:"}


class RecordingGateway(Gateway):
    """The gateway with or without recordings.

    Args:
        where: Where to start it.
        record: What is recorded, as `--recordings`.
    """

    def __init__(self, where: Site, record: str) -> None:
        super().__init__(where)
        self.name = f"{OURS} --recordings {record}"
        self._record = record

    def _more_settings(self) -> dict[str, str]:
        return {"DOCK_GATEWAY_RECORDINGS": self._record}

    def dock(self, robot: str) -> None:
        """Let a robot dock."""
        self._post([f"/dock?robot={robot}"], {})
