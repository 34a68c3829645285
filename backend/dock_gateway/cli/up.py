"""`dock-gateway up`: all parts as supervised processes. One Ctrl-C ends them all."""

import asyncio
import contextlib
import os
import signal
import ssl
import subprocess
import sys
import time
from collections.abc import Mapping, MutableMapping, Sequence
from functools import partial

import click
import httpx2

from dock_gateway.cli.options import option_name, read_settings, settings_options
from dock_gateway.cli.programs import find_program
from dock_gateway.cli.start import check_start
from dock_gateway.client.connection import tls_context
from dock_gateway.doctor.machine import own_url
from dock_gateway.settings import Settings
from robot_io.children import MAX_ROBOTS, end_with_parent

# Seconds that the parts have to end by themselves.
END_TIMEOUT = 2.3

Programs = dict[str, tuple[str, tuple[str, ...]]]

# The robot's programs and their ROS arguments: with a simulated robot, and for the tutorial.
SIMULATED: Programs = {
    "the docking server": ("docking_server", ("-p", "controller:=dock_pose")),
    "the simulator": ("dock_simulator", ()),
}
TUTORIAL: Programs = {"the action server": ("connect_to_charging_dock_server", ())}


class Part:
    """One supervised process, restarted when it dies.

    Args:
        name: Its name in messages.
        command: Starts it.
        longest: The longest delay before it is started again, in seconds.
    """

    def __init__(self, name: str, command: Sequence[str], longest: float) -> None:
        self.name = name
        self._longest = longest
        self._command = command
        self._backoff = 1.0
        self._restart_at: float | None = None
        self.start()

    def start(self) -> None:
        """Start the process in its own session: Ctrl-C reaches only the supervisor, which ends the parts in order."""
        self._restart_at = None
        self.started_at = time.monotonic()
        self.process = subprocess.Popen(self._command, start_new_session=True, preexec_fn=end_with_parent)

    def look(self) -> None:
        """Restart the process if it has died, after a growing delay."""
        now = time.monotonic()
        if self._restart_at is not None:
            if now >= self._restart_at:
                self.start()
        elif (code := self.process.poll()) is not None:
            self._backoff = 1.0 if now - self.started_at > 4 * self._backoff else min(2 * self._backoff, self._longest)
            click.echo(
                f"dock-gateway: {self.name} ended ({code}); starting it again in {self._backoff:g} s",
                err=True,
            )
            self._restart_at = now + self._backoff


def _end(parts: Sequence[Part], timeout: float) -> None:
    deadline = time.monotonic() + timeout
    for part in parts:
        if part.process.poll() is None:
            part.process.terminate()
            part.process.send_signal(signal.SIGCONT)  # a frozen process could not end
    for part in parts:
        try:
            part.process.wait(max(0.0, deadline - time.monotonic()))
        except subprocess.TimeoutExpired:
            click.echo(f"dock-gateway: {part.name} does not exit and is killed", err=True)
            part.process.kill()
            part.process.wait()


async def _announce(url: str) -> None:
    context = tls_context(url)
    if context is not None:  # the certificate is for another name than that of this machine's loopback interface
        context.check_hostname = False
        context.verify_mode = ssl.CERT_NONE
    async with httpx2.AsyncClient(timeout=1.0, trust_env=False, verify=context or True) as http:
        ready = False
        while not ready:
            await asyncio.sleep(0.1)
            with contextlib.suppress(httpx2.HTTPError, ValueError, KeyError):
                ready = (await http.get(f"{url}/readyz")).json()["ready"]
    click.secho(f"\n  dock-gateway is ready: open {url}   (Ctrl-C ends it)\n", bold=True)


async def supervise(
    commands: Mapping[str, Sequence[str]],
    url: str,
    *,
    start_window: float = 5.0,
    longest_delay: float = 10.0,
    end_timeout: float = END_TIMEOUT,
) -> bool:
    """Run the parts until a signal arrives. Return False if the gateway, the first part, could not be started.

    Args:
        commands: Start the parts.
        url: Where the gateway will be.
        start_window: Seconds. A gateway that ends earlier has not started at all: its port is taken, or its settings
            are wrong.
        longest_delay: Maximum seconds before a part that has died is started again.
        end_timeout: Seconds that the parts have to end by themselves.
    """
    ended = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:  # `nohup` sets it to be ignored
            asyncio.get_running_loop().add_signal_handler(number, ended.set)
    parts = [Part(name, command, longest_delay) for name, command in commands.items()]
    started_by = time.monotonic() + start_window
    announcing = asyncio.create_task(_announce(url))
    try:
        while not ended.is_set():
            if time.monotonic() < started_by and parts[0].process.poll() is not None:
                return False  # starting it again would not help
            for part in parts:
                part.look()
            await asyncio.sleep(0.1)
    finally:
        announcing.cancel()
        _end(parts, end_timeout)
    return True


def stay_on_this_machine(environment: MutableMapping[str, str], *, always: bool) -> None:
    """Limit ROS discovery to this machine. Unless `always`, the environment can override that."""
    if not always:
        environment.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        return
    wanted = environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    peers = environment.pop("ROS_STATIC_PEERS", "")
    environment["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    if wanted != "LOCALHOST" or peers:
        click.echo(
            "dock-gateway: the simulated robot is visible on this machine only, whatever the ROS variables say",
            err=True,
        )


def robot_commands(programs: Programs, settings: Settings) -> dict[str, list[str]]:
    """Return the command lines of the robot's programs, in its namespace.

    Raises:
        click.ClickException: One of them is not installed.
    """
    namespace = settings.namespace.strip("/")
    remap = ("-r", f"__ns:=/{namespace}") if namespace else ()
    commands = {}
    for part, (program, arguments) in programs.items():
        ros_args = (*arguments, *remap)
        commands[part] = [find_program(program), *(("--ros-args", *ros_args) if ros_args else ())]
    return commands


def fleet(robots: int) -> list[str]:
    """Return the command line of a simulated fleet."""
    return [sys.executable, "-m", "docking.nodes.simulated_fleet", str(robots)]


def default_robot(settings: Settings, robots: int) -> str:
    """Return the robot of a fleet that a request without one means.

    Raises:
        click.UsageError: The settings name a robot that is not one of the fleet.
    """
    names = [f"robot{number}" for number in range(1, robots + 1)]
    name = settings.namespace.strip("/") or names[0]
    if name not in names:
        raise click.UsageError(f"namespace: the robots are /{names[0]} to /{names[-1]}, and /{name} is none of them")
    return f"/{name}"


@click.command()
@click.option(
    "--no-sim", is_flag=True, help="No simulated robot: the tutorial's action server, and batteries published by hand."
)
@click.option(
    "--robots",
    type=click.IntRange(1, MAX_ROBOTS),
    help="Number of simulated robots, /robot1, /robot2, …, instead of one without a namespace. The setting of this "
    "name is an option of `serve`; here, only the variable DOCK_GATEWAY_ROBOTS sets it.",
)
@partial(settings_options, leave_out={"robots"})
def up(no_sim: bool, robots: int | None, **options: str | None) -> None:
    """Run the gateway, a docking server and a simulated robot together, and keep them running.

    They meet only ROS nodes on this machine: trying it out must not move a robot that happens to be on the same
    network. With --no-sim, ROS_AUTOMATIC_DISCOVERY_RANGE may say otherwise.
    """
    settings = read_settings(options)
    if robots is not None:
        if no_sim:
            raise click.UsageError("--robots are simulated: leave out --no-sim")
        options["namespace"] = default_robot(settings, robots)
        settings = read_settings(options)
    if settings.port == 0:
        raise click.UsageError("port: `up` prints the address before the gateway runs, so the port must not be 0")
    check_start(settings, os.environ, docking=True)
    stay_on_this_machine(os.environ, always=not no_sim)
    arguments = [f"{option_name(name)}={value}" for name, value in options.items() if value is not None]
    programs = TUTORIAL if no_sim else SIMULATED
    commands = robot_commands(programs, settings) if robots is None else {"the fleet": fleet(robots)}

    gateway = [sys.executable, "-m", "dock_gateway", "serve", *arguments]
    running = supervise(
        {"the gateway": gateway} | commands, own_url(settings), end_timeout=END_TIMEOUT + 0.2 * (robots or 0)
    )
    if not asyncio.run(running):
        raise click.ClickException("the gateway could not be started; see the messages above")
