"""How fast a stop is answered while many are asked for: `python -m benchmarks.stops --help`."""

import argparse
import asyncio
import sys
import time
from collections import Counter
from contextlib import ExitStack

from tests.support.domain import ros_domain
from tests.support.gateway import RunningGateway, running_gateway
from tests.support.processes import Process, ros_environment
from tests.support.waiting import wait_until

from benchmarks.machine import describe

CONNECTIONS = 64  # what is asked for goes round them, whether the one before was answered or not
SETTLE = 5.0


async def subscribe(url: str, count: int) -> list[tuple[asyncio.StreamWriter, asyncio.Task[None]]]:
    """Readers of every event, which throw away what they read."""

    async def drain(reader: asyncio.StreamReader) -> None:
        while await reader.read(1 << 16):
            pass

    host, port = url.removeprefix("http://").split(":")
    writers = []
    for _ in range(count):
        reader, writer = await asyncio.open_connection(host, int(port))
        writer.write(
            f"GET /ws/feedback?include=system HTTP/1.1\r\nHost: {host}:{port}\r\nConnection: Upgrade\r\n"
            "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n".encode()
        )
        answer = await reader.readuntil(b"\r\n\r\n")
        assert b" 101 " in answer, answer
        writers.append((writer, asyncio.create_task(drain(reader))))
    return writers


async def press(url: str, rate: float, seconds: float, body: bytes) -> tuple[list[float], Counter[str]]:
    """Ask for stops at a rate, on kept connections; milliseconds to each answer, and what the answers were."""
    host, port = url.removeprefix("http://").split(":")
    request = f"POST /stop HTTP/1.1\r\nHost: {host}:{port}\r\nContent-Length: {len(body)}\r\n\r\n".encode() + body
    took: list[float] = []
    answers: Counter[str] = Counter()
    free: asyncio.Queue[tuple[asyncio.StreamReader, asyncio.StreamWriter]] = asyncio.LifoQueue()

    async def one() -> None:
        begun = time.perf_counter()
        try:
            reader, writer = free.get_nowait() if not free.empty() else await asyncio.open_connection(host, int(port))
            writer.write(request)
            head = (await asyncio.wait_for(reader.readuntil(b"\r\n\r\n"), 10)).decode()
            length = int(head.lower().partition("content-length: ")[2].split("\r\n")[0])
            await reader.readexactly(length)
            answers[head.split()[1]] += 1
            free.put_nowait((reader, writer))
        except (TimeoutError, OSError, asyncio.IncompleteReadError) as error:
            answers[type(error).__name__] += 1
        took.append((time.perf_counter() - begun) * 1000)

    tasks = []
    begun = time.perf_counter()
    for number in range(int(rate * seconds)):
        due = begun + number / rate
        if (early := due - time.perf_counter()) > 0:
            await asyncio.sleep(early)
        tasks.append(asyncio.create_task(one()))
    await asyncio.gather(*tasks)
    return took, answers


def row(name: str, took: list[float], answers: Counter[str]) -> str:
    """A line of the table."""
    took = sorted(took)
    half, most = (took[min(len(took) - 1, int(share * len(took)))] for share in (0.5, 0.99))
    told = ", ".join(f"{count} x {answer}" for answer, count in answers.most_common())
    return f"| {name:<40} | {half:7.1f} | {most:7.1f} | {took[-1]:7.1f} | {told} |"


async def measure(gateway: RunningGateway, arguments: argparse.Namespace) -> None:
    """All of the table."""

    async def add(name: str, rate: float, seconds: float, body: bytes = b"{}") -> None:
        print(row(f"{name}, {rate:g}/s", *await press(gateway.url, rate, seconds, body)), flush=True)

    rate, seconds = arguments.rate, arguments.seconds
    name = f"{arguments.robots} robots"
    print(f"| {'stops':<40} | p50 ms  | p99 ms  | max ms  | answers |", flush=True)
    await add(name, 2, 5)
    await add(f"{name}, not latched", 2, 5, b'{"latch": false}')
    await add(name, rate, seconds)
    readers = await subscribe(gateway.url, arguments.subscribers)
    name += f", {arguments.subscribers} subscribers"
    await asyncio.sleep(SETTLE)
    await add(name, 2, 5)
    await add(name, rate, seconds)
    await asyncio.to_thread(gateway.http.delete, "/stop")
    await add(f"{name}, released before", rate, seconds)
    for writer, task in readers:
        task.cancel()
        writer.close()


def main() -> None:
    """Run it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robots", type=int, default=300)
    parser.add_argument("--subscribers", type=int, default=1000)
    parser.add_argument("--rate", type=float, default=400)
    parser.add_argument("--seconds", type=float, default=7.5)
    arguments = parser.parse_args()
    print(describe())
    with ExitStack() as stack:
        domain = stack.enter_context(ros_domain())
        command = (sys.executable, "-m", "tests.support.robots", "--robots", str(arguments.robots))
        robots = stack.enter_context(Process(*command, env=ros_environment(domain)))
        gateway = stack.enter_context(running_gateway(domain, max_subscribers=str(arguments.subscribers + 10)))
        begun = time.monotonic()
        wait_until(lambda: len(gateway.http.get("/robots").json()["robots"]) > arguments.robots, "all robots", 300)
        print(f"all robots known after {time.monotonic() - begun:.1f} s", flush=True)
        time.sleep(SETTLE)
        asyncio.run(measure(gateway, arguments))
        print("\n".join(line for line in robots.output.splitlines() if line.startswith("halted"))[-200:])
        print("\n".join(line for line in gateway.process.output.splitlines() if "ERROR" in line)[:1000])


if __name__ == "__main__":
    main()
