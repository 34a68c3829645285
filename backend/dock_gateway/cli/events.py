"""Events and messages, as the commands print them for a person."""

from typing import Any

import click
import orjson

from dock_gateway.core.log_config import printable

POWER_SUPPLY_STATUS = {0: "UNKNOWN", 1: "CHARGING", 2: "DISCHARGING", 3: "NOT CHARGING", 4: "FULL"}
BY_NAME = {name.replace(" ", "_").lower(): number for number, name in POWER_SUPPLY_STATUS.items()}


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
