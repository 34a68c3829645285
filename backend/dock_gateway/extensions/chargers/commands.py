"""`dock-gateway shared-dock`: lists the docks that robots share, enters them, and says what a person sees there."""

from typing import Any
from urllib.parse import quote

import click

from dock_gateway.cli.asking import asks, gateway, print_answer, print_json, print_table, wanted
from dock_gateway.cli.groups import CommandGroup


@click.group(name="shared-dock", cls=CommandGroup)
def shared_dock() -> None:
    """Let a dock have one robot at a time."""


@shared_dock.command(name="list")
@asks
def list_shared_docks() -> None:
    """List the shared docks: who has each, and who waits for it."""
    with gateway() as client:
        found = client.request("GET", "/shared-docks")
    if wanted("as_json"):
        print_json(found)
        return
    rows = [
        (each["dock_id"], each["state"], each["detail"], ", ".join(one["robot"] for one in each["waiting"]) or "-")
        for each in found["shared_docks"]
    ]
    print_table(("DOCK", "STATE", "WHO", "WAITING"), rows, "no shared docks: `dock-gateway shared-dock enter` one")


@shared_dock.command()
@click.argument("dock_id")
@click.option("--robot", "names", metavar="NAME", multiple=True, help="A robot that it fits; all by default.")
@click.option("--group", "groups", metavar="NAME", multiple=True, help="A group of robots that it fits.")
@click.option(
    "--pose",
    type=(float, float, float),
    metavar="X Y YAW",
    help="Where the docked robot stands: metres and radians in the frame map.",
)
@click.option("--type", "kind", metavar="NAME", help="Its type at the docking servers.")
@click.option(
    "--waiting-place",
    "places",
    type=(float, float, float),
    metavar="X Y YAW",
    multiple=True,
    help="Where a robot waits for it: metres and radians in the frame map. Once for each robot.",
)
@asks
def enter(
    dock_id: str,
    names: tuple[str, ...],
    groups: tuple[str, ...],
    *,
    pose: tuple[float, float, float] | None,
    kind: str | None,
    places: tuple[tuple[float, float, float], ...],
) -> None:
    """Share a dock, or change what the options say of it. DOCK_ID is what the docking servers call it."""
    body: dict[str, Any] = {}
    if names or groups:
        body["robots"] = {"names": names, "groups": groups}
    if pose is not None:
        body["pose"] = _pose(pose)
    if kind is not None:
        body["type"] = kind or None
    if places:
        body["waiting_places"] = [*map(_pose, places)]
    with gateway() as client:
        docks = client.request("GET", "/shared-docks")["shared_docks"]
    known: dict[str, Any] = next((each for each in docks if each["dock_id"] == dock_id), {})
    kept = {name: known[name] for name in ("robots", "pose", "type", "waiting_places") if name in known}
    _show("PUT", dock_id, "", kept | body, known.get("etag"))


@shared_dock.command()
@click.argument("dock_id")
@asks
def remove(dock_id: str) -> None:
    """Share a dock no more: nothing is reserved there."""
    with gateway() as client:
        client.request("DELETE", _path(dock_id))


@shared_dock.command()
@click.argument("dock_id")
@click.option("--occupied-by", metavar="WHO", help="`nobody`, `unknown` (a robot without a gateway), or a robot.")
@click.option("--out-of-order", "note", metavar="WHY", help="No robot is to be sent there.")
@click.option("--in-order", is_flag=True, help="It works again.")
@asks
def report(dock_id: str, occupied_by: str | None, note: str | None, in_order: bool) -> None:
    """Say what you see at a dock."""
    if note is not None and in_order:
        raise click.UsageError("say --out-of-order or --in-order")
    body: dict[str, Any] = {} if occupied_by is None else {"occupied_by": occupied_by}
    if note is not None:
        body |= {"out_of_order": True, "note": note}
    if in_order:
        body |= {"out_of_order": False}
    if not body:
        raise click.UsageError("say --occupied-by, --out-of-order or --in-order")
    _show("POST", dock_id, "/report", body)


@shared_dock.command()
@asks
def file() -> None:
    """Print the docks that have a pose as a file for docking servers: their dock_database."""
    from dock_gateway.extensions.chargers.dock_database import render  # noqa: PLC0415 - only this command needs it

    with gateway() as client:
        docks = client.request("GET", "/shared-docks")["shared_docks"]
    if not (text := render({each["dock_id"]: each for each in docks})):
        raise click.ClickException("no shared dock has a pose: `dock-gateway shared-dock enter lab --pose X Y YAW`")
    click.echo(text, nl=False)


def _pose(numbers: tuple[float, float, float]) -> dict[str, float]:
    return dict(zip(("x", "y", "theta"), numbers, strict=True))


def _path(dock_id: str) -> str:
    return f"/shared-docks/{quote(dock_id, safe='')}"


def _show(method: str, dock_id: str, rest: str, body: dict[str, Any], if_match: str | None = None) -> None:
    """Send a request about a dock, and print the dock."""
    with gateway() as client:
        found = client.request(method, _path(dock_id) + rest, body, if_match=if_match)
    print_answer(found, f"{found['dock_id']} {found['state']}: {found['detail']}")


COMMANDS = (shared_dock,)
