"""Many simulated sites behind one hub on one core: the age of its overview, its cost, and what it adds to a command.

make bench-sites BENCH_ARGS="--sites 50 --robots 20 --seconds 120"
"""

import argparse
import asyncio
import json
import os
import re
import shutil
import signal
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from http import HTTPStatus
from http.client import HTTPConnection
from pathlib import Path
from statistics import median

import orjson
from tests.support.processes import BIN, Process, free_port
from tests.support.site_broker import SiteBroker
from websockets.asyncio.client import connect

from benchmarks.figures import percentile
from benchmarks.http import Connection
from benchmarks.machine import Cpu, rss_mb
from dock_gateway.sites.identity import Signer

ROOT = Path(__file__).parent.parent
STAMP = re.compile(rb'"stamp":\{"sec":(\d+),"nanosec":(\d+)\}')
# Processes of the sites; the core of the hub, and that of everything else.
PROCESSES, HUB_CORE, OTHER_CORE = 4, 0, 1
WARM_UP = 10.0


class Bench:
    """A hub with its sites.

    Args:
        folder: For their files.
        sites: How many.
        robots: Robots of each.
        profile: Where the hub writes a profile, if anywhere.
    """

    def __init__(self, stack: ExitStack, folder: Path, sites: int, robots: int, profile: Path | None) -> None:
        self.names = [f"site{number}" for number in range(sites)]
        self.robots = robots
        keys = Signer.load_or_create(folder / "hub-key.json").public_keys()
        (folder / "keys.json").write_text(json.dumps(keys))
        broker = SiteBroker(folder, *self.names)
        broker.start()
        stack.callback(broker.kill)
        self.port, self.direct_port = free_port(), free_port()
        processes = min(PROCESSES, sites)
        for process in range(processes):
            names = self.names[process::processes]
            logins = {name: broker.url_for(name) for name in names}
            (folder / f"logins{process}.json").write_text(json.dumps(logins))
            arguments = ["--brokers", str(folder / f"logins{process}.json"), "--keys", str(folder / "keys.json")]
            arguments += ["--robots", str(robots), "--change-period", "0.5"]
            arguments += ["--port", str(self.direct_port)] if process == 0 else []
            command = [
                *on_core(OTHER_CORE),
                str(BIN / "python"),
                "-m",
                "tests.extensions.sites.simulated_site",
                *arguments,
            ]
            stack.enter_context(Process(*command, *names, env=dict(os.environ), cwd=ROOT)).wait_for("serving")
        settings = {
            "port": str(self.port),
            "nats": broker.url_for("hub"),
            "hub_private_key": str(folder / "hub-key.json"),
            "database_url": f"sqlite:///{folder}/hub.db",
            "spool_path": str(folder / "spool"),
            "log_level": "warning",
        }
        environment = os.environ | {f"DOCK_GATEWAY_{name.upper()}": value for name, value in settings.items()}
        program = [str(BIN / "dock-gateway")]
        if profile is not None:
            program = [str(BIN / "python"), "-m", "cProfile", "-o", str(profile), *program]
        self.hub = stack.enter_context(Process(*on_core(HUB_CORE), *program, "hub", env=environment))
        self._wait_for_sites()

    def _wait_for_sites(self) -> None:
        deadline = time.monotonic() + 120
        while time.monotonic() < deadline and self.hub.running:
            try:
                with Connection(self.port) as connection:
                    _, answer = connection.request("GET", "/sites")
                    _, robots = connection.request("GET", "/robots")
                if len(robots["robots"]) == len(self.names) * self.robots:
                    return
            except OSError:
                answer = None
            time.sleep(0.2)
        raise TimeoutError(f"not all sites are there: {orjson.dumps(answer)[:600]!r}\n{self.hub.output[-2000:]}")

    async def read(self, seconds: float) -> list[float]:
        """Read the overview; return how old each change of a robot was when it arrived, in ms."""
        ages: list[float] = []
        url = f"ws://127.0.0.1:{self.port}/ws/feedback?include=fleet&feedback=false"
        async with connect(url, max_size=None, compression=None) as websocket:
            await websocket.recv()
            deadline = time.monotonic() + seconds
            while time.monotonic() < deadline:
                text = await websocket.recv(decode=False)
                now = time.time()
                if b'"type":"robots"' in text[:100]:
                    ages.extend((now - int(sec) - int(nanosec) / 1e9) * 1e3 for sec, nanosec in STAMP.findall(text))
        return ages

    def commands(self, count: int) -> tuple[list[float], list[float]]:
        """Send the same command to one site directly and through the hub, in turns; return the ms that each took."""
        direct, through = [], []
        site, hub = (HTTPConnection("127.0.0.1", port, timeout=30) for port in (self.direct_port, self.port))
        with closing(site), closing(hub):
            for _ in range(count):
                direct.append(_time(site, "/dock?robot=/robot1"))
                time.sleep(0.05)
                through.append(_time(hub, f"/sites/{self.names[0]}/dock?robot=/robot1"))
                time.sleep(0.05)
        return direct, through


def _time(connection: HTTPConnection, path: str) -> float:
    start = time.perf_counter()
    connection.request("POST", path, b'{"seconds": 0.01}', {"Content-Type": "application/json"})
    answer = connection.getresponse()
    text = answer.read()
    assert answer.status == HTTPStatus.ACCEPTED, text
    return (time.perf_counter() - start) * 1e3


def on_core(core: int) -> list[str]:
    """The beginning of a command that runs on one core, where that can be chosen."""
    return ["taskset", "-c", str(core % (os.cpu_count() or 1))] if shutil.which("taskset") else []


@contextmanager
def running(sites: int, robots: int, profile: Path | None = None) -> Iterator[Bench]:
    """A hub that has all its sites."""
    with tempfile.TemporaryDirectory(prefix="bench-sites-") as folder, ExitStack() as stack:
        yield Bench(stack, Path(folder), sites, robots, profile)


async def measure(bench: Bench, seconds: float, commands: int) -> dict[str, object]:
    """Measure for some time, with one reader of the overview."""
    await bench.read(WARM_UP)
    memory = [rss_mb(bench.hub.pid)]

    async def watch_memory() -> None:
        while True:
            await asyncio.sleep(seconds / 10)
            memory.append(rss_mb(bench.hub.pid))

    watching = asyncio.create_task(watch_memory())
    before = Cpu.of(bench.hub.pid)
    ages = sorted(await bench.read(seconds))
    cpu = Cpu.of(bench.hub.pid).percent_since(before)
    watching.cancel()
    reading = asyncio.create_task(bench.read(commands * 0.15))
    direct, through = await asyncio.to_thread(bench.commands, commands)
    await reading
    changes = len(bench.names) * bench.robots * 2 * seconds
    return {
        "sites x robots": f"{len(bench.names)} x {bench.robots}",
        "seconds": seconds,
        "changes read, of those made": f"{len(ages)} of {changes:.0f}",
        "age of a change at the reader, ms: p50": round(median(ages)),
        "p99": round(percentile(ages, 0.99)),
        "worst": round(ages[-1]),
        "hub, % of a core": round(cpu),
        "hub, MB at the beginning, at most, at the end": f"{memory[0]:.0f}, {max(memory):.0f}, {memory[-1]:.0f}",
        "command directly, ms: p50, p99": _both(direct),
        "command through the hub, ms: p50, p99": _both(through),
        "the hub adds at p50, ms": round(median(through) - median(direct), 1),
    }


def _both(values: list[float]) -> str:
    return f"{median(values):.1f}, {percentile(sorted(values), 0.99):.1f}"


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser("benchmarks.sites", description="Measure a hub; see docs/performance.md")
    parser.add_argument("--sites", type=int, default=50)
    parser.add_argument("--robots", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--commands", type=int, default=100)
    parser.add_argument("--profile", type=Path, help="run the hub under cProfile, and write that there")
    options = parser.parse_args()
    with running(options.sites, options.robots, options.profile) as bench:
        for name, value in asyncio.run(measure(bench, options.seconds, options.commands)).items():
            print(f"{name}: {value}")
        if options.profile:
            bench.hub.send_signal(signal.SIGINT)
            bench.hub.wait()


if __name__ == "__main__":
    main()
