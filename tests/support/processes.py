"""Processes under test: started with a ROS environment of their own, read line by line, always ended."""

import os
import random
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Self

from tests.support.forks import Fork
from tests.support.waiting import PATIENCE, wait_until

BIN = Path(sys.executable).parent
# Options of our action clients: on a busy machine a server is found late, which only tests of the limit are about.
PATIENT_CLIENT = ("--timeout", f"{PATIENCE:g}")
# Seconds that a program takes to end: the promise is 3 s, a machine that is shared gets twice that.
GONE_WITHIN = 6.0
# What Fast DDS writes to standard error about its transport through shared memory.
FAST_DDS = "RTPS_TRANSPORT_SHM"
# In an order of each process's own: the workers of a run must not meet at the same port.
_ports = iter(random.SystemRandom().sample(range(10_000, 32_768), k=22_768))


def ros_environment(domain: int, **more: str) -> dict[str, str]:
    """The environment of a process that must meet only those on `domain`, on this machine."""
    return {
        **os.environ,
        "PATH": f"{BIN}{os.pathsep}{os.environ['PATH']}",
        "AMENT_PREFIX_PATH": os.pathsep.join(filter(None, (sys.prefix, os.environ.get("AMENT_PREFIX_PATH")))),
        "ROS_DOMAIN_ID": str(domain),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "PYTHONUNBUFFERED": "1",
        "PYTHONFAULTHANDLER": "1",
        **more,
    }


def free_port(kind: socket.SocketKind = socket.SOCK_STREAM) -> int:
    """A port of this machine that nothing listens on now, another one at each call.

    It is none of those that the system gives to connections (32768 and above on Linux): one that is free now would
    be taken by the next connection of any program, before our server listens on it.
    """
    return next(port for port in _ports if _is_free(port, kind))


def _is_free(port: int, kind: socket.SocketKind) -> bool:
    with socket.socket(type=kind) as listener:
        if kind is socket.SOCK_STREAM:
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)  # as servers do: fine if one has just ended
        try:
            listener.bind(("127.0.0.1", port))
        except OSError:
            return False
        return True


def is_stopped(pid: int) -> bool:
    """Whether none of a process's threads runs."""
    stats = [task.joinpath("stat").read_text() for task in Path(f"/proc/{pid}/task").iterdir()]
    return all(stat.rpartition(")")[2].split()[0] in "TZ" for stat in stats)


class Process:
    """A running program whose output (both streams) can be waited for.

    Use it as a context manager: it is ended (SIGTERM, after 5 s SIGKILL) on the way out.
    """

    def __init__(self, *command: str, env: dict[str, str], cwd: Path | None = None) -> None:
        self._process = self._start(command, env, cwd)
        self.pid = self._process.pid
        self._lines: list[str] = []
        self._changed = threading.Condition()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _start(self, command: tuple[str, ...], env: dict[str, str], cwd: Path | None) -> subprocess.Popen[str] | Fork:
        return subprocess.Popen(
            command,
            env=env,
            cwd=cwd,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            with self._changed:
                self._lines.append(line.rstrip("\n"))
                self._changed.notify_all()
        with self._changed:
            self._changed.notify_all()

    @property
    def output(self) -> str:
        """All that was printed so far."""
        with self._changed:
            return "\n".join(self._lines)

    @property
    def own_lines(self) -> list[str]:
        """The lines of the program itself. Fast DDS adds its own where a killed process left shared memory behind."""
        return [line for line in self.output.splitlines() if FAST_DDS not in line]

    def wait_for(self, text: str, timeout: float = PATIENCE) -> str:
        """Wait for a line that holds `text` and return it; fail with the whole output otherwise."""
        deadline = time.monotonic() + timeout
        seen = 0
        with self._changed:
            while True:
                for line in self._lines[seen:]:
                    if text in line:
                        return line
                seen = len(self._lines)
                left = deadline - time.monotonic()
                if left <= 0 or not self._reader.is_alive():
                    raise AssertionError(f"{text!r} not seen; the output was:\n" + "\n".join(self._lines))
                self._changed.wait(min(left, 0.2))

    def send_signal(self, number: signal.Signals) -> None:
        """Send a signal to the process; after SIGSTOP, wait until none of its threads runs."""
        self._process.send_signal(number)
        if number == signal.SIGSTOP:
            wait_until(lambda: is_stopped(self.pid), f"process {self.pid} stands still")

    def wait(self, timeout: float = PATIENCE) -> int:
        """Wait for the end and return the exit code."""
        code = self._process.wait(timeout)
        self._reader.join(2)
        return code

    @property
    def running(self) -> bool:
        """Whether it has not ended yet."""
        return self._process.poll() is None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self.running:
            self._process.send_signal(signal.SIGCONT)  # a frozen process cannot end
            self._process.terminate()
            try:
                self._process.wait(5)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        self._reader.join(2)
        assert self._process.stdout is not None
        self._process.stdout.close()


class ForkedProcess(Process):
    """The same, for our programs and for modules (`-m`), which start sooner as forks; see `tests/support/forks.py`."""

    def __init__(self, *command: str, env: dict[str, str], typed: str = "") -> None:
        self._typed = typed
        super().__init__(*command, env=env)

    def _start(self, command: tuple[str, ...], env: dict[str, str], cwd: Path | None) -> Fork:
        assert cwd is None
        return Fork(*command, env=env, typed=self._typed)


def client_process(domain: int, client: str, *arguments: str) -> ForkedProcess:
    """One of our action clients, which waits for its server as long as a test does."""
    return ForkedProcess(client, *PATIENT_CLIENT, *arguments, env=ros_environment(domain))
