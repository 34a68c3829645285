"""FastAPI with uvicorn as they come, in the product's environment: what any request costs at least."""

import asyncio
import os
import time

from tests.support.processes import Process, free_port

from benchmarks.figures import STOCK
from benchmarks.http import Connection, KeptConnection
from benchmarks.site import LEAKING, PRODUCT, ROOT
from benchmarks.systems.base import Impossible

START_TIMEOUT = 20.0


class Stock:
    """A server with one route."""

    name = STOCK

    async def start(self) -> None:
        """Start it, and come back when it answers."""
        port = free_port()
        self._kept = KeptConnection(lambda: Connection(port))
        command = [str(PRODUCT / "bin/python"), "-m", "uvicorn", "benchmarks.nodes.stock:app", "--port", str(port)]
        environment = {name: value for name, value in os.environ.items() if name not in LEAKING}
        self._process = Process(*command, "--no-access-log", env=environment, cwd=ROOT).__enter__()
        deadline = time.monotonic() + START_TIMEOUT
        while time.monotonic() < deadline and self._process.running:
            try:
                self.healthz()
            except OSError:
                await asyncio.sleep(0.05)
            else:
                return
        raise Impossible(f"it did not answer within {START_TIMEOUT:g} s: {self._process.output[-600:]}")

    def healthz(self) -> float:
        """One request, in ms."""
        return self._kept.get().time("GET", "/healthz")

    async def close(self) -> None:
        """End it."""
        await asyncio.to_thread(self._process.__exit__)
