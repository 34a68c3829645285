"""`dock-gateway battery`: shows a battery state; `publish` and `unpublish` act for a robot that has no driver."""

from typing import Any

import click

from dock_gateway.cli.asking import asks, gateway, print_json, robot_option, wanted
from dock_gateway.cli.events import BY_NAME, describe
from dock_gateway.cli.groups import CommandGroup
from dock_gateway.client import Battery


class StatusChoice(click.ParamType[int]):
    """A power supply status, by name or number."""

    name = "status"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """Return the number."""
        text = str(value).replace("-", "_").lower()
        if text in BY_NAME:
            return BY_NAME[text]
        if text.isdecimal() and int(text) <= 255:
            return int(text)
        return self.fail(f"{value!r} is not one of {', '.join(BY_NAME)} or 0 to 255", param, ctx)


@click.group(cls=CommandGroup, invoke_without_command=True)
@robot_option
@asks
@click.pass_context
def battery(ctx: click.Context, robot: str | None) -> None:
    """Show the battery state of a robot."""
    if ctx.invoked_subcommand is not None:
        return
    with gateway() as client:
        if wanted("as_json"):
            print_json(client.request("GET", "/battery", params=_of(robot)))
        else:
            show_battery(client.battery(robot))


@battery.command()
@click.option("--status", type=StatusChoice(), required=True, help="Power supply status, by name or number.")
@click.option("--voltage", type=float, help="Voltage in V.")
@click.option("--percentage", type=float, help="Charge, 0 to 1.")
@click.option("--rate", type=float, help="Publish repeatedly, at this rate in Hz.")
@robot_option
@asks
@click.pass_context
def publish(
    ctx: click.Context,
    status: int,
    voltage: float | None,
    percentage: float | None,
    rate: float | None,
    robot: str | None,
) -> None:
    """Publish a battery state, once or at a rate."""
    state = {"power_supply_status": status, "voltage": voltage, "percentage": percentage}
    where = _of(robot or _before(ctx))
    with gateway() as client:
        if rate is None:
            answer = client.request("POST", "/battery", state, params=where)
        else:
            answer = client.request("PUT", "/battery/publisher", {"state": state, "rate_hz": rate}, params=where)
    if wanted("as_json"):
        print_json(answer)
    else:
        often = "" if rate is None else f", {rate:g} times a second from now on"
        click.echo(f"published: {describe({'state': state})}{often}")


@battery.command()
@robot_option
@asks
@click.pass_context
def unpublish(ctx: click.Context, robot: str | None) -> None:
    """Stop publishing a battery state at a rate."""
    with gateway() as client:
        answer = client.request("DELETE", "/battery/publisher", params=_of(robot or _before(ctx)))
    if wanted("as_json"):
        print_json(answer)
    else:
        click.echo("publishing has stopped")


def _before(ctx: click.Context) -> str | None:
    """Return the robot that is named before the subcommand."""
    return None if ctx.parent is None else ctx.parent.params.get("robot")


def _of(robot: str | None) -> dict[str, str]:
    return {} if robot is None else {"robot": robot}


def show_battery(battery: Battery) -> None:
    """Print the latest battery state."""
    if battery.state is None or battery.age_s is None:
        others = ", ".join(battery.other_topics)
        click.echo(f"no battery state yet{f'; there are batteries on {others}' if others else ''}")
        return
    text = describe({"state": battery.state, "percentage": battery.percentage})
    click.echo(f"{text} ({battery.age_s:.1f} s ago{', stale' if battery.stale else ''})")
    for wrong in battery.implausible:
        click.echo(f"not used: {wrong['field']} is {wrong['value']}, but should be {wrong['expected']}")
