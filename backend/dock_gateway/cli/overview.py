"""`dock-gateway robots`, `docks` and `alerts`: what a running gateway sees."""

from contextlib import suppress
from typing import Any

import click

from dock_gateway.cli.asking import asks, gateway, print_json, print_table, robot_option, wanted
from dock_gateway.client import Client, Robot
from dock_gateway.core.log_config import printable

DOCKED = {True: "docked", False: "not docked", None: "unknown"}


@click.command()
@click.option("--watch", is_flag=True, help="Print them again whenever one changes.")
@asks
def robots(watch: bool) -> None:
    """List the robots: battery, dock, running goals and stops."""
    with gateway() as client, suppress(KeyboardInterrupt):
        if not watch:
            _print_robots(client)
            return
        for event in client.events(include=["robots"], feedback=False):
            if event.type in ("snapshot", "robots"):
                if not wanted("as_json"):
                    click.clear()
                _print_robots(client)


def _print_robots(client: Client) -> None:
    found = client.robots()
    if wanted("as_json"):
        print_json({"robots": found})
        return
    columns = ("ROBOT", "NAME", "BATTERY", "DOCK", "GOALS", "STOP")
    print_table(columns, [_row(robot) for robot in found], "no robots yet")


def _row(robot: Robot) -> tuple[str, ...]:
    charge = robot.battery["percentage"]
    level = "unknown" if charge is None else f"{charge:.0%}{', charging' if robot.charging else ''}"
    stale = ", stale" if charge is not None and robot.battery["stale"] else ""
    running = ", ".join(f"{goal['verb'] or goal['action_name']} {goal['status']}" for goal in robot.goals)
    stop = "stopped" if robot.stop["latched"] else ""
    return robot.name, robot.display_name or "", f"{level}{stale}", DOCKED[robot.docked], running or "none", stop


@click.command()
@robot_option
@asks
def docks(robot: str | None) -> None:
    """List the docks that a robot's docking server knows."""
    with gateway() as client:
        found = client.request("GET", "/docks", params={} if robot is None else {"robot": robot})
    if wanted("as_json"):
        print_json(found)
        return
    rows = [
        (each["dock_id"], each["type"] or "", each["frame"] or "", "default" * (each["dock_id"] == found["default"]))
        for each in found["docks"]
    ]
    print_table(("DOCK", "TYPE", "FRAME", ""), rows, "the docking server knows no docks by name")


@click.command()
@asks
def alerts() -> None:
    """List the alerts that are active."""
    with gateway() as client:
        found: dict[str, Any] = client.request("GET", "/alerts")
    if wanted("as_json"):
        print_json(found)
        return
    for alert in found["alerts"]:
        where = f" {alert['robot']}:" if alert["robot"] else ""
        seen = " (acknowledged)" if alert["acknowledged"] else ""
        click.echo(printable(f"{alert['severity']}:{where} {alert['title']}{seen}"))
        click.echo(printable(f"    {alert['detail']}"))
    if not found["alerts"]:
        click.echo("no active alerts")
