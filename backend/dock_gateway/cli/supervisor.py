"""Runs programs as supervised processes until a signal comes, and ends them together."""

import asyncio
import contextlib
import signal
import ssl
import subprocess
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from operator import itemgetter
from pathlib import Path
from typing import Any, NamedTuple

import click
import httpx2

from dock_gateway.cli.output import LAST_LINES, Output
from dock_gateway.client.connection import tls_context
from robot_io.children import end_with_parent

# Seconds that the programs have to end by themselves. A docking server stays for up to 2 s, until its robot stands.
END_TIMEOUT = 3.0


class Program:
    """One supervised process, restarted when it dies.

    Args:
        name: Its name in messages.
        command: Starts it.
        longest: The longest delay before it is started again, in seconds.
        output: Where its lines go.
        environment: Its variables; by default those of this process.
    """

    def __init__(
        self,
        name: str,
        command: Sequence[str],
        longest: float,
        output: Output,
        environment: Mapping[str, str] | None = None,
    ) -> None:
        self.name = name
        self._longest = longest
        self._output = output
        self._command = command
        self._environment = environment
        self._backoff = 1.0
        self._restart_at: float | None = None
        self.start()

    def start(self) -> None:
        """Start the process in its own session: Ctrl-C reaches only the supervisor, which ends all in order."""
        self._restart_at = None
        self.started_at = time.monotonic()
        self.process = subprocess.Popen(
            self._command,
            env=self._environment,
            start_new_session=True,
            preexec_fn=end_with_parent,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            encoding="utf-8",
            errors="backslashreplace",
        )
        self.reader: threading.Thread = self._output.follow(self.process)

    def restart_if_dead(self) -> None:
        """Restart the process if it has died, after a growing delay."""
        now = time.monotonic()
        if self._restart_at is not None:
            if now >= self._restart_at:
                self.start()
        elif (code := self.process.poll()) is not None:
            self._backoff = 1.0 if now - self.started_at > 4 * self._backoff else min(2 * self._backoff, self._longest)
            self._output.note(f"{self.name} ended ({code}); starting it again in {self._backoff:g} s")
            self._restart_at = now + self._backoff


def _end(programs: Sequence[Program], timeout: float, output: Output) -> None:
    deadline = time.monotonic() + timeout
    for program in programs:
        if program.process.poll() is None:
            program.process.terminate()
            program.process.send_signal(signal.SIGCONT)  # a frozen process could not end
    for program in programs:
        try:
            program.process.wait(max(0.0, deadline - time.monotonic()))
        except subprocess.TimeoutExpired:
            output.note(f"{program.name} does not exit and is killed")
            program.process.kill()
            program.process.wait()
    last_lines_by = time.monotonic() + LAST_LINES
    for program in programs:
        program.reader.join(max(0.0, last_lines_by - time.monotonic()))


class ReadinessProbe(NamedTuple):
    """Tells whether everything is up.

    Attributes:
        path: Is asked for at the gateway.
        holds: Whether its answer, a JSON document, says so.
        text: Lines to print then, each indented by two spaces.
    """

    path: str = "/readyz"
    holds: Callable[[Any], bool] = itemgetter("ready")
    text: str = ""


GATEWAY_READY = ReadinessProbe()


async def _announce(url: str, readiness: ReadinessProbe, log: Path) -> None:
    context = tls_context(url)
    if context is not None:  # the certificate is for another name than that of this machine's loopback interface
        context.check_hostname = False
        context.verify_mode = ssl.CERT_NONE
    async with httpx2.AsyncClient(timeout=1.0, trust_env=False, verify=context or True) as http:
        ready = False
        while not ready:
            await asyncio.sleep(0.1)
            with contextlib.suppress(httpx2.HTTPError, ValueError, KeyError):
                ready = readiness.holds((await http.get(f"{url}{readiness.path}")).json())
    click.secho(f"\n  dock-gateway is ready: open {url}   (Ctrl-C ends it)\n", bold=True)
    click.echo(f"{readiness.text}  Log:  {log}\n")


async def supervise(
    commands: Mapping[str, Sequence[str]],
    url: str,
    output: Output,
    *,
    environments: Mapping[str, Mapping[str, str]] = {},
    readiness: ReadinessProbe = GATEWAY_READY,
    start_window: float = 5.0,
    longest_delay: float = 10.0,
    end_timeout: float = END_TIMEOUT,
) -> bool:
    """Run the programs until a signal arrives. Return False if the gateway, the first program, could not be started.

    Args:
        commands: Start the programs.
        url: Where the gateway will be.
        output: Where lines of the programs go.
        environments: The variables of programs that have their own, by the program's name.
        readiness: When everything is up.
        start_window: Seconds. A gateway that ends earlier has not started at all: its port is taken, or its settings
            are wrong.
        longest_delay: Maximum seconds before a program that has died is started again.
        end_timeout: Seconds that the programs have to end by themselves.
    """
    click.echo(f"Starting {', '.join(commands)} …")
    ended = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:  # `nohup` sets it to be ignored
            asyncio.get_running_loop().add_signal_handler(number, ended.set)
    programs = [
        Program(name, command, longest_delay, output, environments.get(name)) for name, command in commands.items()
    ]
    started_by = time.monotonic() + start_window
    announcing = asyncio.create_task(_announce(url, readiness, output.path))
    try:
        while not ended.is_set():
            if time.monotonic() < started_by and programs[0].process.poll() is not None:
                return False  # starting it again would not help
            for program in programs:
                program.restart_if_dead()
            await asyncio.sleep(0.1)
    finally:
        announcing.cancel()
        _end(programs, end_timeout, output)
    return True
