"""Case (i): one camera of 640 x 480 at 10 Hz to one viewer and to five, as Image and as CompressedImage."""

import asyncio
import time
from collections.abc import Sequence
from contextlib import suppress
from functools import partial

from tests.support.processes import Process

from benchmarks.cases import take_turns
from benchmarks.figures import Results
from benchmarks.http import Connection
from benchmarks.machine import Cpu
from benchmarks.options import Options
from benchmarks.site import PRODUCT, ROOT
from benchmarks.systems.base import Impossible
from benchmarks.systems.gateway import Gateway

PATH = "/cameras"
FORMS = {"Image": "raw", "JPEG": "jpeg"}
VIEWERS = (0, 1, 5)
DISCOVERY, SETTLE = 60.0, 1.0


async def cameras(results: Results, systems: Sequence[Gateway], options: Options) -> None:
    """Show the camera; without a viewer nothing is subscribed, and the processor time is that of an idle gateway."""
    for name, form in FORMS.items():
        for viewers in VIEWERS:
            case = f"(i) {name}, viewers: {viewers}"
            measure = partial(_measure, results, case, form, viewers, seconds=options.seconds)
            await take_turns(results, case, systems, options, measure)


async def _measure(results: Results, case: str, form: str, viewers: int, system: Gateway, *, seconds: float) -> None:
    command = (str(PRODUCT / "bin/python"), str(ROOT / "benchmarks/nodes/camera.py"), form)
    with Process(*command, env=system.site.environment(), cwd=ROOT) as camera:
        await asyncio.to_thread(camera.wait_for, "filming", DISCOVERY)
        await asyncio.to_thread(_until_found, system.port)
        counts = [0] * viewers
        watching = [asyncio.create_task(_watch(system.port, counts, viewer)) for viewer in range(viewers)]
        await asyncio.sleep(SETTLE)
        before, seen = Cpu.of(system.pid), list(counts)
        await asyncio.sleep(seconds)
        used = Cpu.of(system.pid).percent_since(before)
        rates = [(now - then) / seconds for now, then in zip(counts, seen, strict=True)]
        for task in watching:
            task.cancel()
        await asyncio.gather(*watching, return_exceptions=True)
    results.add(case, "CPU", system.name, used, "%")
    if viewers:
        results.add(case, "rate of the slowest", system.name, min(rates), "Hz")


def _until_found(port: int) -> None:
    deadline = time.monotonic() + DISCOVERY
    while time.monotonic() < deadline:
        with Connection(port) as connection:
            if connection.request("GET", PATH)[1].get("cameras"):
                return
        time.sleep(0.1)
    raise Impossible("the camera was not found")


async def _watch(port: int, counts: list[int], viewer: int) -> None:
    """Count the pictures of a stream."""
    reader, writer = await asyncio.open_connection("127.0.0.1", port, limit=1 << 22)
    try:
        writer.write(f"GET {PATH}/benchmark/image/stream HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n".encode())
        while True:
            await reader.readuntil(b"\r\n--picture\r\n")
            counts[viewer] += 1
    finally:
        with suppress(OSError):
            writer.close()
