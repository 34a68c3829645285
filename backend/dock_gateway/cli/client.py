"""`dock-gateway dock`, `undock`, `cancel`, `stop`, `release`, `watch`, `battery`: a client of a running gateway."""

import sys
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from typing import Any

import click
import orjson

from dock_gateway.client import Battery, Client, ClientError, GatewayUnreachable, Goal, GoalState
from dock_gateway.core.goal import GoalStatus, encode
from dock_gateway.core.log_config import printable

POWER_SUPPLY_STATUS = {0: "UNKNOWN", 1: "CHARGING", 2: "DISCHARGING", 3: "NOT CHARGING", 4: "FULL"}
BY_NAME = {name.replace(" ", "_").lower(): number for number, name in POWER_SUPPLY_STATUS.items()}

# Seconds that a stop may take, in addition to those that the gateway waits for action servers.
STOP_WITHIN = 4.0

url_option = click.option(
    "--url",
    envvar="DOCK_GATEWAY_URL",
    default="http://127.0.0.1:8000",
    show_default=True,
    help="Base URL of the gateway.",
)
robot_option = click.option("--robot", help="Namespace of the robot, such as /robot1.")
json_option = click.option("--json", "as_json", is_flag=True, help="Print one JSON document per line.")


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


@contextmanager
def gateway(url: str, *, timeout: float = 15.0) -> Iterator[Client]:
    """A client of the gateway there, whose errors end the command with one sentence.

    The token is that in DOCK_GATEWAY_TOKEN; no option, because other users of the machine can read command lines.

    Raises:
        click.ClickException: The gateway does not answer, or refuses. The message says why.
    """
    try:
        with Client(url, timeout=timeout) as client:
            yield client
    except GatewayUnreachable as error:
        hint = "start one with `dock-gateway up`, or name another with --url or DOCK_GATEWAY_URL"
        raise click.ClickException(f"{error}; {hint}") from None
    except ClientError as error:
        raise click.ClickException(printable(str(error))) from None


def show(event: dict[str, Any], *, as_json: bool) -> None:
    """Print an event for a person, or as JSON."""
    if as_json:
        click.echo(orjson.dumps(event))
        return
    kind, goal_id = event["type"], event.get("goal_id", "")[:8]
    if kind == "snapshot":
        running = [goal for goal in event["goals"] if not goal["finished_at"]]
        for goal in running or event["goals"][:1]:
            click.echo(
                f"{goal['goal_id'][:8]} {goal['status']}"
                + (f" ({goal['origin']})" if goal["origin"] != "gateway" else "")
            )
    elif kind == "status":
        running = event["status"] == "executing" and event["stage"]
        stage = f", {event['stage'].lower().replace('_', ' ')}" if running else ""
        error = f": {event['error']['detail']}" if event["error"] else ""
        click.echo(printable(f"{goal_id} {event['status']}{stage}{error}"))
    elif kind == "feedback":
        click.echo(printable(f"{goal_id} feedback {describe(event['feedback'])}"))
    elif kind == "result":
        click.echo(printable(f"{goal_id} result {describe(event['result'] or {})}"))
    elif kind in ("dropped", "closing"):
        click.echo(orjson.dumps(event))


def describe(message: dict[str, Any]) -> str:
    """Return a battery state in words, or any other message as JSON."""
    state = next(iter(message.values()), None)
    if not isinstance(state, dict) or "power_supply_status" not in state:
        return orjson.dumps(message).decode()
    status = state["power_supply_status"]
    parts = [POWER_SUPPLY_STATUS.get(status, str(status))]
    percentage = message.get("percentage", state["percentage"])
    if percentage is not None:
        parts.append(f"{percentage:.0%}" if 0 <= percentage <= 1 else f"percentage {percentage:g}, not 0 to 1")
    if state["voltage"] is not None:
        parts.append(f"{state['voltage']:g} V")
    return ", ".join(parts)


def follow(goal: Goal, *, as_json: bool) -> GoalState:
    """Show a goal's events until it ends. Return its state."""
    for event in goal.events():
        if event.type != "heartbeat":
            show(event.document, as_json=as_json)
    return goal.refresh()


@click.command()
@click.option("--status", type=StatusChoice(), default=1, help="Desired power supply status: charging or full.")
@click.option("--voltage", type=float, help="Desired voltage in V.")
@click.option("--percentage", type=float, help="Desired charge, 0 to 1.")
@click.option("--no-wait", is_flag=True, help="Do not wait for the end; print the goal id.")
@json_option
@url_option
def dock(url: str, status: int, voltage: float | None, percentage: float | None, no_wait: bool, as_json: bool) -> None:
    """Send the robot to its charging dock and show its feedback. Ctrl-C cancels the goal."""
    state = {"power_supply_status": status, "voltage": voltage, "percentage": percentage}
    with gateway(url) as client:
        send(partial(client.dock, {"desired_battery_state": state}), no_wait=no_wait, as_json=as_json)


@click.command()
@click.option("--no-wait", is_flag=True, help="Do not wait for the end; print the goal id.")
@json_option
@url_option
def undock(url: str, no_wait: bool, as_json: bool) -> None:
    """Drive the robot off its charging dock and show its feedback. Ctrl-C cancels the goal."""
    with gateway(url) as client:
        send(client.undock, no_wait=no_wait, as_json=as_json)


def send(send_once: Callable[..., Goal], *, no_wait: bool, as_json: bool) -> None:
    """Send a goal and show its events until it ends. Exit with 1 unless it succeeded."""
    key = str(uuid.uuid4())
    goal: Goal | None = None
    try:
        goal = send_once(key=key)
        if no_wait:
            click.echo(encode(goal.state) if as_json else goal.id)
            return
        if not as_json:
            click.echo(f"goal {goal.id} accepted")
        state = follow(goal, as_json=as_json)
    except KeyboardInterrupt:
        click.echo("canceling …", err=True)
        goal = goal or send_once(key=key)  # it may have been sent already: the same key returns it
        goal.cancel()
        state = follow(goal, as_json=as_json)
    if state.status != "succeeded":
        sys.exit(1)


@click.command()
@click.argument("goal_id", required=False)
@url_option
def cancel(url: str, goal_id: str | None) -> None:
    """Cancel a goal; without GOAL_ID, the running one."""
    running = {"status": [str(status) for status in GoalStatus if not status.terminal]}
    with gateway(url) as client:
        if goal_id is None:
            pages = [client.request("GET", path, params=running) for path in ("/dock", "/undock")]
            found = [goal["goal_id"] for page in pages for goal in page["goals"]]
            if not found:
                raise click.ClickException("no goal is running")
            goal_id = found[0]
        goal = client.goal(goal_id).cancel()
    click.echo(f"goal {goal.goal_id} {goal.status}")


class StopCommand(click.Command):
    """A command line that stops robots although it is not valid: all of them then."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the arguments; of those that are not valid, only the address."""
        url = args[at + 1 : at + 2] if "--url" in args and (at := args.index("--url")) >= 0 else []
        try:
            return super().parse_args(ctx, args)
        except click.UsageError as error:
            click.echo(printable(f"{error.format_message()} Stopping all robots."), err=True)
            return super().parse_args(ctx, ["--url", *url] if url else [])


@click.command(cls=StopCommand, context_settings={"ignore_unknown_options": True})
@click.argument("names", metavar="[ROBOT]...", nargs=-1)
@click.option("--by", help="Your name, shown to others.")
@click.option("--no-latch", is_flag=True, help="Accept new goals again immediately.")
@click.option(
    "--robot", "robots", multiple=True, help="Namespace of a robot, such as /robot1; several to stop several."
)
@url_option
def stop(url: str, names: tuple[str, ...], robots: tuple[str, ...], no_latch: bool, by: str | None) -> None:
    """Stop robots, all by default: zero velocity, every goal is canceled, and none is sent until `release`.

    If the options are not valid, all robots are stopped.
    """
    unknown = [name for name in names if name.startswith("-")]
    if unknown:
        click.echo(printable(f"Unknown option {unknown[0]}. Stopping all robots."), err=True)
    try:
        with gateway(url, timeout=STOP_WITHIN) as client:
            report = client.stop(*([] if unknown else [*robots, *names]), latch=not no_latch, by=by)
    except click.ClickException as error:
        advice = "the stop is NOT confirmed; use the robots' own emergency stop if they move"
        raise click.ClickException(f"{advice}: {error.message}") from None
    stopped = ", ".join(report.stopped) or "no robot that you may see"
    click.echo(printable(f"zero velocity published to {stopped}; canceling {', '.join(report.canceling) or 'no goal'}"))
    if report.not_stopped:
        click.echo(printable(f"not stopped: {', '.join(report.not_stopped)}"))
    if report.warning:
        click.echo(printable(f"warning: {report.warning['detail']}"), err=True)
    if report.stop["latched"]:
        click.echo("goals are refused until the stop is released: dock-gateway release")
    for failure in report.failed:
        click.echo(printable(f"{failure['action_name'] or failure['robot']}: {failure['detail']}"), err=True)
    for name in report.unconfirmed:
        click.echo(f"{name}: the action server has not answered yet", err=True)
    if report.failed or report.unconfirmed:
        sys.exit(1)


@click.command()
@robot_option
@url_option
def release(url: str, robot: str | None) -> None:
    """Release a stop, of all robots by default: new goals are accepted again. This moves no robot."""
    with gateway(url) as client:
        client.release(robot)
    click.echo("released")


@click.command()
@click.argument("goal_id", required=False)
@json_option
@url_option
def watch(url: str, goal_id: str | None, as_json: bool) -> None:
    """Show events as they happen: of every goal, or of GOAL_ID until it has ended."""
    with gateway(url) as client, suppress(KeyboardInterrupt):
        if goal_id is not None:
            follow(client.goal(goal_id), as_json=as_json)
            return
        for event in client.events():
            show(event.document, as_json=as_json)


@click.command()
@click.option("--status", type=StatusChoice(), help="Power supply status, by name or number.")
@click.option("--voltage", type=float, help="Voltage in V.")
@click.option("--percentage", type=float, help="Charge, 0 to 1.")
@click.option("--rate", type=float, help="Publish repeatedly, at this rate in Hz.")
@click.option("--stop", "stop_publishing", is_flag=True, help="Stop publishing.")
@url_option
def battery(
    url: str,
    status: int | None,
    voltage: float | None,
    percentage: float | None,
    rate: float | None,
    stop_publishing: bool,
) -> None:
    """Show the battery state; with --status, publish one."""
    if status is None and not stop_publishing and (voltage, percentage, rate) != (None, None, None):
        raise click.UsageError("--status is needed to publish a battery state")
    state = {"power_supply_status": status, "voltage": voltage, "percentage": percentage}
    with gateway(url) as client:
        if stop_publishing:
            client.request("DELETE", "/battery/publisher")
            click.echo("publishing has stopped")
        elif status is None:
            show_battery(client.battery())
        elif rate is None:
            client.request("POST", "/battery", state)
            click.echo(f"published: {describe({'state': state})}")
        else:
            client.request("PUT", "/battery/publisher", {"state": state, "rate_hz": rate})
            click.echo(f"published: {describe({'state': state})}, {rate:g} times a second from now on")


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
