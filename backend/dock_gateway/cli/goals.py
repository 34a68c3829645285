"""`dock-gateway dock`, `undock`, `send`, `cancel`, `watch`, `goals`, `goal`: goals of a running gateway."""

import sys
import uuid
from collections.abc import Callable
from contextlib import suppress
from datetime import datetime, timedelta
from functools import partial
from typing import Any

import click

from dock_gateway.cli.asking import (
    asks,
    for_robot,
    gateway,
    one_robot,
    print_json,
    print_table,
    robot_option,
    wanted,
)
from dock_gateway.cli.events import EventPrinter, describe
from dock_gateway.client import Client, Goal, GoalHandle
from dock_gateway.core.goal import GoalStatus
from dock_gateway.core.log_config import printable

UNTIL = {"charging": 1, "full": 4}
RUNNING = [str(status) for status in GoalStatus if not status.terminal]
UNITS = {"s": "seconds", "m": "minutes", "h": "hours", "d": "days"}

no_wait_option = click.option("--no-wait", is_flag=True, help="Do not wait for the end; print the goal id.")


class Since(click.ParamType[str]):
    """A time, such as 2026-11-29T08:00:00Z, or how long ago, such as 30m, 2h or 7d."""

    name = "time"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the time, as RFC 3339 has it."""
        text = str(value)
        try:
            if text[-1:] in UNITS:
                return (datetime.now().astimezone() - timedelta(**{UNITS[text[-1]]: float(text[:-1])})).isoformat()
            return datetime.fromisoformat(text).astimezone().isoformat()
        except (ValueError, OverflowError):
            return self.fail(f"{value!r} is no time such as 2026-11-29T08:00Z, nor such as 30m, 2h or 7d", param, ctx)


@click.command()
@for_robot
@click.option("--dock", "dock_name", metavar="NAME", help="The dock, for action servers that know docks by name.")
@click.option("--until", type=click.Choice([*UNTIL]), help="The state in which the battery has to be.")
@click.option("--voltage", type=float, help="Desired voltage in V.")
@click.option("--percentage", type=float, help="Desired charge, 0 to 1.")
@no_wait_option
@asks
def dock(
    name: str | None,
    robot: str | None,
    dock_name: str | None,
    until: str | None,
    voltage: float | None,
    percentage: float | None,
    no_wait: bool,
) -> None:
    """Send a robot to its charging dock and show its feedback. Ctrl-C cancels the goal.

    Without ROBOT, it is the one in the gateway's settings.
    """
    goal: dict[str, Any] = {} if dock_name is None else {"dock_id": dock_name}
    if (until, voltage, percentage) != (None, None, None):
        status = UNTIL[until or "charging"]
        goal["desired_battery_state"] = {"power_supply_status": status, "voltage": voltage, "percentage": percentage}
    with gateway() as client:
        carry_out(partial(client.dock, goal or None, robot=one_robot(name, robot)), no_wait=no_wait)


@click.command()
@for_robot
@no_wait_option
@asks
def undock(name: str | None, robot: str | None, no_wait: bool) -> None:
    """Drive a robot off its charging dock and show its feedback. Ctrl-C cancels the goal."""
    with gateway() as client:
        carry_out(partial(client.undock, robot=one_robot(name, robot)), no_wait=no_wait)


@click.command()
@click.argument("action")
@click.argument("goal", default="{}")
@no_wait_option
@asks
def send(action: str, goal: str, no_wait: bool) -> None:
    """Send GOAL, as YAML or JSON, to any ACTION and show its feedback. Ctrl-C cancels it.

    As `ros2 action send_goal`, for example: dock-gateway send /fibonacci '{order: 5}'
    """
    import yaml  # noqa: PLC0415 - only this command needs it

    try:
        fields = yaml.safe_load(goal)
    except yaml.YAMLError as error:
        raise click.UsageError(f"the goal is not YAML: {error}") from None
    if not isinstance(fields, dict):
        raise click.UsageError("the goal is not like '{order: 5}'")
    with gateway() as client:
        carry_out(partial(client.send, action, fields), no_wait=no_wait)


def carry_out(send_once: Callable[..., GoalHandle], *, no_wait: bool) -> None:
    """Send a goal and show its events until it ends. Exit with 1 unless it succeeded."""
    key = str(uuid.uuid4())
    goal: GoalHandle | None = None
    try:
        goal = send_once(key=key)
        if no_wait:
            if wanted("as_json"):
                print_json(goal.state)
            else:
                click.echo(goal.id)
            return
        if not wanted("as_json"):
            click.echo(f"goal {goal.id} accepted")
        state = follow(goal)
    except KeyboardInterrupt:
        click.echo("canceling …", err=True)
        goal = goal or send_once(key=key)  # it may have been sent already: the same key returns it
        goal.cancel()
        state = follow(goal)
    if state.status != "succeeded":
        sys.exit(1)


def follow(goal: GoalHandle) -> Goal:
    """Show a goal's events until it ends. Return its state."""
    printer = EventPrinter(as_json=bool(wanted("as_json")))
    for event in goal.events():
        printer.show(event.document)
    return goal.refresh()


@click.command()
@click.argument("goal_id", required=False)
@robot_option
@asks
def cancel(goal_id: str | None, robot: str | None) -> None:
    """Cancel a goal; without GOAL_ID, the one that is running, of --robot or of all."""
    with gateway() as client:
        goal = client.goal(goal_id or _only_running(client, robot)).cancel()
    if wanted("as_json"):
        print_json(goal)
    else:
        click.echo(f"goal {goal.goal_id} {goal.status}")


def _only_running(client: Client, robot: str | None) -> str:
    found = client.request("GET", "/goals", params={"status": RUNNING} | ({} if robot is None else {"robot": robot}))
    goals = found["goals"]
    if not goals:
        raise click.ClickException("no goal is running")
    if len(goals) > 1:
        which = "".join(f"\n  {goal['goal_id']}  {goal['action_name']}" for goal in goals)
        raise click.ClickException(printable("several goals are running; name one of them:") + which)
    return str(goals[0]["goal_id"])


@click.command()
@click.argument("goal_id", required=False)
@robot_option
@asks
def watch(goal_id: str | None, robot: str | None) -> None:
    """Show events as they happen: of every goal, of a robot's, or of GOAL_ID until it has ended."""
    with gateway() as client, suppress(KeyboardInterrupt):
        if goal_id is not None:
            follow(client.goal(goal_id))
            return
        printer = EventPrinter(as_json=bool(wanted("as_json")))
        for event in client.events(robot=robot):
            printer.show(event.document)


@click.command()
@robot_option
@click.option("--action", metavar="NAME", help="Only goals of this action, such as /fibonacci.")
@click.option("--status", "statuses", multiple=True, help="Only goals in this state, or `running`; may be repeated.")
@click.option("--since", type=Since(), help="Only goals since then: a time, or how long ago, such as 2h or 7d.")
@click.option("--limit", type=click.IntRange(1, 500), default=20, show_default=True, help="Maximum number of goals.")
@asks
def goals(robot: str | None, action: str | None, statuses: tuple[str, ...], since: str | None, limit: int) -> None:
    """List goals, the newest first: of all robots and actions by default."""
    listed = [state for status in statuses for state in (RUNNING if status == "running" else [status])]
    query = {"robot": robot, "action": action, "since": since, "limit": limit, "status": listed}
    with gateway() as client:
        found = client.request("GET", "/goals", params={name: value for name, value in query.items() if value})
    if wanted("as_json"):
        print_json(found)
        return
    print_table(
        ("GOAL", "ACTION", "STATUS", "CREATED", "ERROR"),
        [
            (
                goal["goal_id"],
                goal["action_name"],
                goal["status"],
                local(goal["created_at"]),
                (goal["error"] or {}).get("code", ""),
            )
            for goal in found["goals"]
        ],
        "no such goals",
    )


@click.command()
@click.argument("goal_id")
@asks
def goal(goal_id: str) -> None:
    """Show one goal: its state, why it ended, and its messages."""
    with gateway() as client:
        state = client.goal(goal_id).state
    if wanted("as_json"):
        print_json(state)
        return
    lines = {
        "goal": state.goal_id,
        "action": f"{state.action_name} ({state.action_type})",
        "status": f"{state.status}{', stalled' if state.stalled else ''}",
        "stage": state.stage,
        "error": state.error and f"{state.error.code}: {state.error.detail}",
        "created": local(state.created_at),
        "ended": state.finished_at and local(state.finished_at),
        "sent": state.goal and describe(state.goal),
        "feedback": state.feedback and describe(state.feedback),
        "result": state.result and describe(state.result),
    }
    for heading, text in lines.items():
        if text:
            click.echo(printable(f"{heading:9} {text}"))


def local(time: str | datetime) -> str:
    """Return a time of this machine's zone."""
    moment = datetime.fromisoformat(time) if isinstance(time, str) else time
    return f"{moment.astimezone():%Y-%m-%d %H:%M:%S}"
