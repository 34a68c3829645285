"""`dock-gateway mission`: queues missions from files and templates, follows them, and changes them."""

import json
import sys
import time
from collections.abc import Iterable
from typing import Any

import click

from dock_gateway.cli.asking import asks, gateway, print_answer, print_json, print_table, robot_option, wanted
from dock_gateway.cli.groups import CommandGroup
from dock_gateway.client import Client
from dock_gateway.core.log_config import printable
from dock_gateway.extensions.missions.step import KINDS

# Seconds between two looks at a mission that is followed.
INTERVAL = 1.0
ENDED = ("succeeded", "failed", "canceled")


@click.group(cls=CommandGroup)
def mission() -> None:
    """Let a robot do one thing after the other."""


class _Filename(click.ParamType[str]):
    """The name of a file, which is opened later."""

    name = "filename"


@mission.command()
@click.argument("file", type=_Filename(), required=False)
@click.argument("arguments", nargs=-1)
@click.option("--template", metavar="ID", help="Queue a mission of this template, with ARGUMENTS such as shelf=a3.")
@robot_option
@click.option("--group", metavar="NAME", help="Let the free robot of this group with the most charge take it.")
@click.option("--no-wait", is_flag=True, help="Do not follow it.")
@asks
def run(
    *, file: str | None, arguments: tuple[str, ...], template: str | None, no_wait: bool, **whose: str | None
) -> None:
    """Queue the mission in a JSON file, or one of a template, and follow it to its end; `-` reads it from stdin.

    Arguments of a template are JSON, or text where they are none: `shelf=a3 seconds=5`.
    Ctrl-C ends the command, not the mission. The exit code is 1 if it does not succeed.
    """
    if template is not None:
        body = {"template": template, "arguments": dict(map(_argument, filter(None, (file, *arguments))))}
    elif file is None or arguments:
        raise click.UsageError("name one file with a mission, or a template with --template")
    else:
        body = _read(file)
    if whose["group"] is not None and isinstance(body, dict):
        body["group"] = whose["group"]
    params = {} if whose["robot"] is None else {"robot": whose["robot"]}
    with gateway() as client:
        found = client.request("POST", "/missions", body, params=params)
        if not no_wait:
            found = _follow(client, found)
    if wanted("as_json"):
        print_json(found)
    elif no_wait:
        click.echo(found["mission_id"])
    if found["status"] in ("failed", "canceled"):
        sys.exit(1)


def _argument(text: str) -> tuple[str, Any]:
    """Return the name and the value of an argument."""
    name, sign, value = text.partition("=")
    if not sign:
        raise click.BadParameter(f"{text!r} is no argument such as shelf=a3", param_hint="ARGUMENTS")
    try:
        return name, json.loads(value)
    except ValueError:
        return name, value


def _read(file: str) -> Any:
    """Return the mission in a file."""
    try:
        with click.open_file(file, "rb") as opened:
            return json.loads(opened.read())
    except OSError as error:
        raise click.BadParameter(f"{file!r}: {error.strerror}", param_hint="FILE") from None
    except ValueError as error:
        raise click.BadParameter(f"it is no JSON: {error}", param_hint="FILE") from None


def _follow(client: Client, found: dict[str, Any]) -> dict[str, Any]:
    """Print what a mission does until it ends; return it as it is then."""
    said = ""
    while True:
        if (line := _line(found)) != said and not wanted("as_json"):
            click.echo(printable(said := line))
        if found["status"] in ENDED:
            return found
        time.sleep(INTERVAL)
        found = client.request("GET", f"/missions/{found['mission_id']}")


def _line(found: dict[str, Any]) -> str:
    """Return the state of a mission in a line."""
    status, steps = found["status"], found["steps"]
    if status in ENDED:
        why = f": {found['error']['detail']}" if found["error"] else ""
        return f"{found['mission_id']} {status}{why}"
    step = steps[found["step"]]
    place = f"step {found['step'] + 1} of {len(steps)}, {_kind_of(step)}{_rounds_of(step, steps)}"
    held = (
        f", for {found['held_for']}: dock-gateway mission continue {found['mission_id']}" if found["held_for"] else ""
    )
    on_break = f"{found['recharge']['stage']}, then " if found["recharge"] else ""
    return f"{found['mission_id']} {status}: {on_break}{place}{held}"


def _rounds_of(step: dict[str, Any], steps: list[dict[str, Any]]) -> str:
    """Return in which rounds a step is."""
    around = (each for each in steps if each["repeat"] is not None and step["path"].startswith(f"{each['path']}."))
    return "".join(f", round {each['repeat']['round']} of {each['repeat']['times'] or 'many'}" for each in around)


def _kind_of(step: dict[str, Any]) -> str:
    """Return what a step does, in a word or two."""
    if step["action"] is not None:
        return f"action {step['action']['name']}"
    return next(kind for kind in (*KINDS, "repeat", "first_that_works") if step[kind] is not None)


@mission.command(name="list")
@robot_option
@click.option("--all", "everything", is_flag=True, help="Also those that have ended, up to 50 of all.")
@asks
def list_missions(robot: str | None, everything: bool) -> None:
    """List the missions that have not ended: those on their way, then the others in the order in which they begin."""
    params: dict[str, Any] = {} if robot is None else {"robot": robot}
    if not everything:
        params |= {"status": ["queued", "running", "held", "canceling"], "limit": 500}
    with gateway() as client:
        found = client.request("GET", "/missions", params=params)
    if wanted("as_json"):
        print_json(found)
        return
    rows = []
    for each in sorted(found["missions"], key=_turn):
        step = f"{each['step']}/{len(each['steps'])}"
        rows.append((each["mission_id"], _robot_of(each), each["name"] or "", each["status"], step))
    print_table(("MISSION", "ROBOT", "NAME", "STATUS", "STEP"), rows, "no missions")


def _robot_of(found: dict[str, Any]) -> str:
    """Return the robot of a mission, or those that may take it."""
    return found["robot"] or f"one of {found['group']}"


def _turn(found: dict[str, Any]) -> tuple[Any, ...]:
    """Sort missions: those that have begun by robot, those that have not in the order in which they do, ended ones."""
    if found["status"] in ENDED:
        return (2,)
    if found["started_at"] is not None:
        return 0, found["robot"]
    return 1, -found["priority"], found["order"], found["created_at"], found["mission_id"]


@mission.command()
@click.argument("mission_id")
@click.option("--before", metavar="MISSION_ID", help="The mission that comes right behind it.")
@click.option("--after", metavar="MISSION_ID", help="The mission that comes right before it.")
@asks
def move(mission_id: str, before: str | None, after: str | None) -> None:
    """Move a mission that has not begun next to another one of its queue, whose priority it gets."""
    if (before is None) is (after is None):
        raise click.UsageError("say --before or --after which mission")
    place = {"after": after} if before is None else {"before": before}
    with gateway() as client:
        found = client.request("POST", f"/missions/{mission_id}/move", place)
    print_answer(found, _line(found))


@mission.command()
@asks
def templates() -> None:
    """List the templates, with their parameters; those in brackets have a default."""
    with gateway() as client:
        found = client.request("GET", "/mission-templates")
    if wanted("as_json"):
        print_json(found)
        return
    rows = [(each["id"], each["name"] or "", _signature(each["parameters"].items())) for each in found["templates"]]
    print_table(("TEMPLATE", "NAME", "PARAMETERS"), rows, "no templates")


def _signature(parameters: Iterable[tuple[str, dict[str, Any]]]) -> str:
    return " ".join(
        f"{name}=" if each["default"] is None else f"[{name}={json.dumps(each['default'])}]"
        for name, each in parameters
    )


@mission.command()
@asks
def schedules() -> None:
    """List the schedules, each with its next time and what came of the last."""
    with gateway() as client:
        found = client.request("GET", "/schedules")
    if wanted("as_json"):
        print_json(found)
        return
    rows = [
        (each["id"], _taker(each), each["name"] or "", each["next_at"] or "-", _outcome(each["last"]))
        for each in found["schedules"]
    ]
    print_table(("SCHEDULE", "ROBOT", "NAME", "NEXT", "LAST"), rows, "no schedules")


def _taker(schedule: dict[str, Any]) -> str:
    robot: str | None = schedule["robot"]
    return robot or f"any of {schedule['group']}"


def _outcome(last: dict[str, Any] | None) -> str:
    return "-" if last is None else last["mission_id"] or f"{last['code']}: {last['detail']}"


def _change(verb: str, help_text: str) -> click.Command:
    """Return the command that changes a mission."""

    @click.command(name=verb, help=help_text)
    @click.argument("mission_id")
    @asks
    def change(mission_id: str) -> None:
        with gateway() as client:
            found = client.request("POST", f"/missions/{mission_id}/{verb}")
        print_answer(found, _line(found))

    return change


for each in (
    _change("pause", "Hold a mission before its next step."),
    _change("continue", "Let a mission that is held go on."),
    _change("skip", "Let a mission that is held go on without its step."),
    _change("cancel", "End a mission; the goal of its step is canceled first."),
):
    mission.add_command(each)

COMMANDS = (mission,)
