"""What other clients see of a gateway while something goes on: how long a stop takes, gaps in a stream, memory."""

import threading
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from http.client import HTTPConnection, HTTPException
from pathlib import Path
from typing import Any

import orjson
from websockets.exceptions import WebSocketException

from tests.support.clients import connect
from tests.support.gateway import RunningGateway

PAUSE = 0.02


@dataclass
class Findings:
    """Seconds that each request took, seconds between the messages of a stream, and what went wrong."""

    stop: list[float] = field(default_factory=list)
    health: list[float] = field(default_factory=list)
    gaps: list[float] = field(default_factory=list)
    errors: list[str] = field(default_factory=list)

    @property
    def complete(self) -> bool:
        """Whether there is something of each, or something went wrong."""
        return bool(self.errors or (self.stop and self.health and self.gaps))

    def figures(self) -> dict[str, Any]:
        """What a report tells."""
        stops = " / ".join(f"{1000 * quantile(self.stop, share):.0f}" for share in (0.5, 0.99, 1.0))
        return {
            "stops": len(self.stop),
            "stop, median / p99 / worst, ms": stops,
            "healthz, worst, ms": f"{1000 * max(self.health, default=0):.0f}",
            "stream without a message, longest, ms (10 a second are sent)": f"{1000 * max(self.gaps, default=0):.0f}",
            "errors": len(self.errors),
        }


def quantile(values: list[float], share: float) -> float:
    """The value that `share` of them do not exceed."""
    return sorted(values)[min(len(values) - 1, int(share * len(values)))] if values else float("nan")


@contextmanager
def probing(gateway: RunningGateway) -> Iterator[Findings]:
    """Stop, ask for the health and read the battery's stream, each in a thread, as long as the context is open."""
    gateway.publish({"percentage": 0.5}, rate_hz=10.0)
    gateway.stop_once()  # the first answer of each route takes longer
    findings, ended = Findings(), threading.Event()
    probes = (_probe_stop, _probe_health, _probe_stream)
    threads = [threading.Thread(target=probe, args=(gateway.url, findings, ended), daemon=True) for probe in probes]
    for thread in threads:
        thread.start()
    try:
        yield findings
    finally:
        ended.set()
        for thread in threads:
            thread.join(20)


def _probe_stop(url: str, findings: Findings, ended: threading.Event) -> None:
    while not ended.wait(PAUSE):
        findings.stop.append(_ask(url, "POST /stop", findings, b'{"latch": false}'))


def _probe_health(url: str, findings: Findings, ended: threading.Event) -> None:
    while not ended.wait(PAUSE):
        findings.health.append(_ask(url, "GET /healthz", findings))


def _ask(url: str, request: str, findings: Findings, body: bytes = b"") -> float:
    """Ask by a new connection; the seconds that it took."""
    began = time.monotonic()
    try:
        with closing(HTTPConnection(url.removeprefix("http://"), timeout=15)) as connection:
            connection.request(*request.split(), body)
            response = connection.getresponse()
            text = response.read()
        if response.status != 200:
            findings.errors.append(f"{request}: {response.status} {text[:200]!r}")
    except (OSError, HTTPException) as error:
        findings.errors.append(f"{request}: {error!r}")
    return time.monotonic() - began


def _probe_stream(url: str, findings: Findings, ended: threading.Event) -> None:
    try:
        with connect(f"{url.replace('http', 'ws')}/ws/feedback?include=battery", open_timeout=20) as connection:
            orjson.loads(connection.recv(20))
            last = time.monotonic()
            while not ended.is_set():
                connection.recv(20)
                findings.gaps.append(time.monotonic() - last)
                last = time.monotonic()
    except (OSError, WebSocketException) as error:
        findings.errors.append(f"stream: {error!r}")


def memory(pid: int) -> float:
    """Resident megabytes of a process."""
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * 4096 / 1e6


def open_files(pid: int) -> int:
    """How many file descriptors a process has open."""
    return len(list(Path(f"/proc/{pid}/fd").iterdir()))
