"""A real NATS server on a free port of this machine."""

import signal
import socket
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Self

from tests.support.processes import BIN, free_port, is_stopped
from tests.support.waiting import wait_until


class NatsServer:
    """A NATS server. It can be killed and started again on the same port.

    Args:
        folder: Where its configuration and its log are.
        config: More of its configuration, such as users with their permissions.
        scheme: `tls` if the configuration has certificates.
    """

    def __init__(self, folder: Path, config: str = "", scheme: str = "nats") -> None:
        self.port = free_port()
        self.address = f"127.0.0.1:{self.port}"
        self.url = f"{scheme}://{self.address}"
        self.log = folder / f"nats-{self.port}.log"
        self._config = folder / f"nats-{self.port}.conf"
        self._config.write_text(f'listen: "{self.address}"\n{config}\n')
        self._process: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, tb: TracebackType | None) -> None:
        self.kill()

    def url_of(self, user: str, password: str) -> str:
        """Its address for a user."""
        scheme = self.url.partition(":")[0]
        return f"{scheme}://{user}:{password}@{self.address}"

    def start(self) -> None:
        """Start it, and wait until it listens."""
        with self.log.open("ab") as log:
            self._process = subprocess.Popen(
                [BIN / "nats-server", "--config", self._config], stdin=subprocess.DEVNULL, stdout=log, stderr=log
            )
        wait_until(self._listens, f"a NATS server on {self.address}")

    def kill(self) -> None:
        """End it without a word, as a machine that loses its power."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None

    def freeze(self) -> None:
        """Let it hear and say nothing, with its connections open. None of its threads runs any more."""
        process = self._process
        assert process is not None
        process.send_signal(signal.SIGSTOP)
        wait_until(lambda: is_stopped(process.pid), "the NATS server stands still")

    def thaw(self) -> None:
        """Let it go on."""
        assert self._process is not None
        self._process.send_signal(signal.SIGCONT)

    def _listens(self) -> bool:
        assert self._process is not None
        assert self._process.poll() is None, self.log.read_text()
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", self.port)) == 0


@contextmanager
def nats_server(folder: Path, config: str = "", scheme: str = "nats") -> Iterator[NatsServer]:
    """A running NATS server."""
    with NatsServer(folder, config, scheme) as server:
        yield server
