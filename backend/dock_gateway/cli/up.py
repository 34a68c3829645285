"""`dock-gateway up`: all parts as supervised processes. One Ctrl-C ends them all."""

import asyncio
import os
import sys
from collections.abc import MutableMapping
from functools import partial
from importlib.metadata import entry_points
from typing import Any

import click

from dock_gateway.cli.options import SettingsCommand, arguments_of, read_settings, settings_options
from dock_gateway.cli.output import Output, use_one_format
from dock_gateway.cli.programs import find_program
from dock_gateway.cli.start import check_port, check_start
from dock_gateway.cli.supervisor import END_TIMEOUT, ReadinessProbe, supervise
from dock_gateway.doctor.machine import own_url
from dock_gateway.settings import Settings, log_file
from robot_io.children import MAX_ROBOTS

# The most simulated sites.
MAX_SITES = 5

Programs = dict[str, tuple[str, tuple[str, ...]]]

# The robot's programs and their ROS arguments: with a simulated robot, and for the tutorial.
SIMULATED: Programs = {
    "the docking server": ("docking_server", ("-p", "controller:=dock_pose", "-p", "use_sim_time:=true")),
    "the simulator": ("dock_simulator", ("-p", "publish_clock:=true")),
}
TUTORIAL: Programs = {"the action server": ("connect_to_charging_dock_server", ())}

# What to try first. Where it stands in the terminal, a reader has the page open already.
TRY_SIMULATED = """\
  Try:  press Dock: the robot drives to its dock and charges. Then press Undock.
        curl -X POST {url}/dock     does the same
        press Stop: the robot stands still until you press Release.
"""
TRY_TUTORIAL = """\
  Try:  publish a battery state on the robot's page: NOT CHARGING, once a second.
        curl -X POST {url}/dock     the robot turns, and looks for its dock
        publish CHARGING: the goal succeeds.
"""


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


def fleet(robots: int, docks: int | None = None) -> list[str]:
    """Return the command line of a simulated fleet. Without a number of docks, each robot has one."""
    command = [sys.executable, "-m", "docking.nodes.simulated_fleet", str(robots)]
    return command if docks is None else [*command, "--docks", str(docks)]


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


@click.command(cls=SettingsCommand)
@click.option(
    "--no-sim", is_flag=True, help="No simulated robot: the tutorial's action server, and batteries published by hand."
)
@click.option(
    "--robots",
    type=click.IntRange(1, MAX_ROBOTS),
    help="Number of simulated robots, /robot1, /robot2, … in one hall, instead of one without a namespace.",
)
@click.option(
    "--docks", type=click.IntRange(1, MAX_ROBOTS), help="Number of docks for --robots; one for each by default."
)
@click.option(
    "--sites",
    type=click.IntRange(1, MAX_SITES),
    help="Simulated sites, each with a gateway and --robots of its own, behind one hub. Other options are the hub's.",
)
@click.option("-v", "--verbose", is_flag=True, help="Print every line of the log, not only warnings and errors.")
@partial(settings_options, leave_out={"serve_robots"})
def up(no_sim: bool, robots: int | None, docks: int | None, sites: int | None, verbose: bool, **options: Any) -> None:
    """Run the gateway, a docking server and a simulated robot together, until Ctrl-C ends them all.

    They meet only ROS nodes on this machine: trying it out must not move a robot that happens to be on the same
    network. With --no-sim, ROS_AUTOMATIC_DISCOVERY_RANGE may say otherwise.
    """
    settings = read_settings(options)
    if settings.port == 0:
        raise click.UsageError("port: `up` prints the address before the gateway runs, so the port must not be 0")
    if docks is not None and docks > (robots or 0):
        raise click.UsageError("--docks is for --robots, and there is one for each at most")
    if sites is not None:
        if no_sim:
            raise click.UsageError("--sites are simulated: leave out --no-sim")
        if settings.namespace.strip("/"):
            raise click.UsageError("namespace: the robots of --sites have no other names than their site gives them")
        command = None if robots is None else fleet(robots, docks)
        _up_with_sites(sites, command, robots or 1, settings, options, verbose=verbose)
        return
    if robots is not None:
        if no_sim:
            raise click.UsageError("--robots are simulated: leave out --no-sim")
        options["namespace"] = default_robot(settings, robots)
        settings = read_settings(options)
    check_start(settings, os.environ, docking=True)
    stay_on_this_machine(os.environ, always=not no_sim)
    programs = TUTORIAL if no_sim else SIMULATED
    commands = robot_commands(programs, settings) if robots is None else {"the fleet": fleet(robots, docks)}

    gateway = [sys.executable, "-m", "dock_gateway", "serve", *arguments_of(options)]
    url = own_url(settings)
    with open_output(settings, verbose=verbose) as output:
        running = supervise(
            {"the gateway": gateway} | commands,
            url,
            output,
            readiness=ReadinessProbe(text=(TRY_TUTORIAL if no_sim else TRY_SIMULATED).format(url=url)),
            end_timeout=END_TIMEOUT + 0.2 * (robots or 0),
        )
        if not asyncio.run(running):
            raise click.ClickException(f"the gateway could not be started; see the messages above, and {output.path}")


def open_output(settings: Settings, *, verbose: bool) -> Output:
    """Open the log, one for each port, and let ROS write times as the gateway does."""
    use_one_format(os.environ)
    return Output(log_file(f"up-{settings.port}.log"), verbose=verbose)


def _up_with_sites(
    sites: int,
    fleet_command: list[str] | None,
    robots: int,
    settings: Settings,
    options: dict[str, Any],
    *,
    verbose: bool,
) -> None:
    """Run sites, by what another program adds for that; their gateways listen on the ports after the first.

    Raises:
        click.UsageError: That program is not installed.
    """
    run_sites = next(iter(entry_points(group="dock_gateway.demonstrations", name="sites")), None)
    if run_sites is None:
        raise click.UsageError("--sites: the program that spans sites is not installed")
    check_start(settings, os.environ, docking=True)
    ports = [settings.port + number for number in range(1, sites + 1)]
    for port in ports:
        check_port(Settings(port=port))
    stay_on_this_machine(os.environ, always=True)
    if fleet_command is None:
        programs, namespace = robot_commands(SIMULATED, settings), ""
    else:
        programs, namespace = {"the fleet": fleet_command}, "/robot1"
    end_timeout = END_TIMEOUT + 0.2 * sites * robots
    with open_output(settings, verbose=verbose) as output:
        run_sites.load()(ports, own_url(settings), arguments_of(options), programs, namespace, output, end_timeout)
