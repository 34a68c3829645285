"""ros2-http-gateway: HTTP, and Server-Sent Events for the feedback of a goal."""

import asyncio
import hashlib
import tempfile
import time
from pathlib import Path

import orjson
from tests.support.processes import Process, free_port

from benchmarks.http import Connection, KeptConnection
from benchmarks.readers import EventStreamReader, Tally
from benchmarks.site import ACTION, ACTION_TYPE, ROOT, Goal, Site
from benchmarks.systems.base import Impossible, Reading, System, Timing

TOKEN = "benchmark"
START_TIMEOUT = 60.0
STAND_INS = ROOT / "benchmarks/stand_ins"


class HttpGateway(System):
    """The peer.

    Args:
        where: Where to start it.
        prefix: Its Python environment.
    """

    name = "ros2-http-gateway"

    def __init__(self, where: Site, prefix: Path) -> None:
        super().__init__(where)
        self._prefix = prefix

    async def start(self) -> None:
        """Start it and have a first goal accepted."""
        self.port = free_port()
        self._kept = KeptConnection(self._connect)
        digest = hashlib.sha256(TOKEN.encode()).hexdigest()
        config = {
            "endpoints": {"/dock": {"action": f"/{ACTION}", "type": ACTION_TYPE, "roles": ["operator"]}},
            "auth": {"tokens": [{"token_sha256": digest, "user": "benchmark", "roles": ["operator"]}]},
            "http": {"bind": "127.0.0.1", "port": self.port, "base_path": "/api"},
            "ros": {"executor": "multithreaded"},
            "audit": {"sink": "file", "path": "/dev/null"},
        }
        self._folder = tempfile.TemporaryDirectory()
        file = Path(self._folder.name) / "config.yaml"
        file.write_bytes(orjson.dumps(config))
        environment = self.site.environment(self._prefix, PYTHONPATH=str(STAND_INS))
        self.process = Process(str(self._prefix / "bin/ros2-http-gateway"), str(file), env=environment).__enter__()
        await asyncio.to_thread(self._until_accepted)

    def _connect(self) -> Connection:
        return Connection(self.port, headers=f"Authorization: Bearer {TOKEN}\r\n")

    def _until_accepted(self) -> None:
        deadline = time.monotonic() + START_TIMEOUT
        while time.monotonic() < deadline and self.process.running:
            try:
                with self._connect() as connection:
                    if connection.request("POST", "/api/dock", {})[0] == 202:
                        return
            except OSError:
                pass
            time.sleep(0.02)
        raise Impossible(f"no goal was accepted within {START_TIMEOUT:g} s: {self.process.output[:300]}")

    async def submit(self) -> Timing:
        """One goal to its acceptance; its results are asked for by polling, so none is timed."""
        return await asyncio.to_thread(self._submit)

    def _submit(self) -> Timing:
        connection = self._kept.get()
        start = time.perf_counter()
        status, goal = connection.request("POST", "/api/dock", {})
        accepted = time.perf_counter() - start
        assert status == 202, goal
        while connection.request("GET", f"/api/dock/{goal['goal_id']}")[1]["status"] != "succeeded":
            time.sleep(0.002)
        return Timing(accepted * 1e3, None)

    async def stream(self, goal: Goal, readers: int) -> Reading:
        """Read the goal's own stream."""
        tally = Tally()
        with self._connect() as connection:
            body = {"desired_battery_state": goal.state}
            status, answer = await asyncio.to_thread(connection.request, "POST", "/api/dock", body)
        assert status == 202, answer
        cpu = asyncio.create_task(self.cpu_during(goal.seconds, goal.delay))
        path = f"/api/dock/{answer['goal_id']}/stream"
        request = (
            f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{self.port}\r\nAuthorization: Bearer {TOKEN}\r\n\r\n".encode()
        )
        loop = asyncio.get_running_loop()
        connections: list[tuple[asyncio.Transport, EventStreamReader]] = []
        try:
            while len(connections) < readers:
                connections.append(
                    await loop.create_connection(lambda: EventStreamReader(tally, request), "127.0.0.1", self.port)
                )
            await asyncio.wait_for(asyncio.gather(*(reader.begun for _, reader in connections)), START_TIMEOUT)
            used = await cpu
            await tally.settle(goal.count * readers)
        finally:
            for transport, _ in connections:
                transport.close()
        return Reading.of(goal.count * readers, list(tally.latencies), list(tally.stamps), used)

    async def close(self) -> None:
        """End it."""
        if hasattr(self, "process"):
            await super().close()
            self._folder.cleanup()
