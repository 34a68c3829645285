"""Case (j): what the black box costs for one robot, with laser, odometry, transforms and ranges: the simulated one."""

import asyncio
from collections.abc import Sequence
from contextlib import ExitStack

from tests.support.processes import Process

from benchmarks.cases import take_turns
from benchmarks.figures import Results
from benchmarks.machine import Cpu, rss_mb
from benchmarks.options import Options
from benchmarks.site import PRODUCT
from benchmarks.systems.gateway import RecordingGateway

CASE = "(j) 1 robot"
# Seconds until everything is found.
SETTLE = 6.0


async def recordings(results: Results, systems: Sequence[RecordingGateway], options: Options) -> None:
    """Processor time and memory while the robot stands still, and while it docks. Each turn starts the system anew."""
    await take_turns(results, CASE, systems, options, lambda system: _measure(results, system, options))


async def _measure(results: Results, system: RecordingGateway, options: Options) -> None:
    environment = system.site.environment()
    with ExitStack() as stack:
        for program in ("dock_simulator", "docking_server"):
            command = (str(PRODUCT / "bin" / program), "--ros-args", "-r", "__ns:=/robot1")
            await asyncio.to_thread(stack.enter_context, Process(*command, env=environment))
        try:
            await system.start_robots(["/robot1/connect_to_charging_dock"])
            await asyncio.sleep(SETTLE)
            await _cpu(results, system, "CPU at rest", 4 * options.seconds)
            await asyncio.to_thread(system.dock, "/robot1")
            await _cpu(results, system, "CPU while it docks", 2 * options.seconds)
            results.add(CASE, "RSS", system.name, rss_mb(system.pid), "MB")
        finally:
            await system.close()


async def _cpu(results: Results, system: RecordingGateway, what: str, seconds: float) -> None:
    before = Cpu.of(system.pid)
    await asyncio.sleep(seconds)
    results.add(CASE, what, system.name, Cpu.of(system.pid).percent_since(before), "%")
