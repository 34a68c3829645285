"""rclpy's own ActionClient, in a process of its own."""

import asyncio
import tempfile
from typing import Any

import orjson

from benchmarks.figures import BARE
from benchmarks.site import PRODUCT, ROOT, Goal
from benchmarks.systems.base import Reading, System, Timing


class Bare(System):
    """The bare client."""

    name = BARE
    max_readers = 1

    async def start(self) -> None:
        """Start it and have a first goal accepted."""
        await self.start_idle()
        await self._order({"do": "goal"})

    async def start_robots(self, names: list[str]) -> None:
        """Start it, and come back when each robot's action has answered a goal."""
        await self.start_idle()
        await self.read_robots(Goal(10, 1), names)

    async def read_robots(self, goal: Goal, names: list[str]) -> Reading:
        """Have each robot's action run a goal and read all feedback."""
        return await self._read({"do": "robots", "goal": goal.state, "names": names}, goal, len(names))

    async def start_idle(self) -> None:
        """Start it."""
        self._log = tempfile.TemporaryFile()  # noqa: SIM115 - lives as long as the process
        self._process = await asyncio.create_subprocess_exec(
            str(PRODUCT / "bin/python"),
            str(ROOT / "benchmarks/nodes/bare.py"),
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            stderr=self._log,
            env=self.site.environment(),
            cwd=ROOT,
            limit=1 << 27,
        )
        await self._answer()

    @property
    def pid(self) -> int:
        """The process that is measured."""
        return self._process.pid

    async def submit(self) -> Timing:
        """One goal."""
        return Timing(**await self._order({"do": "goal"}))

    async def stream(self, goal: Goal, readers: int) -> Reading:
        """One reader; there is no other kind."""
        return await self._read({"do": "stream", "goal": goal.state}, goal, 1)

    async def _read(self, order: dict[str, Any], goal: Goal, actions: int) -> Reading:
        cpu = asyncio.create_task(self.cpu_during(goal.seconds, goal.delay))
        answer = await self._order(order)
        return Reading.of(goal.count * actions, answer["latencies"], answer["stamps"], await cpu)

    async def close(self) -> None:
        """End its input, which ends it."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        try:
            await asyncio.wait_for(self._process.wait(), 10)
        except TimeoutError:
            self._process.kill()
            await self._process.wait()
        self._log.close()

    async def _order(self, order: dict[str, Any]) -> Any:
        assert self._process.stdin is not None
        self._process.stdin.write(orjson.dumps(order) + b"\n")
        return await self._answer()

    async def _answer(self) -> Any:
        assert self._process.stdout is not None
        line = await asyncio.wait_for(self._process.stdout.readline(), 120)
        if not line:
            self._log.seek(0)
            raise RuntimeError(self._log.read().decode())
        return orjson.loads(line)
