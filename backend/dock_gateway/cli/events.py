"""Events and messages, as the commands print them for a person."""

from typing import Any

import click
import orjson

from dock_gateway.core.log_config import printable

POWER_SUPPLY_STATUS = {0: "UNKNOWN", 1: "CHARGING", 2: "DISCHARGING", 3: "NOT CHARGING", 4: "FULL"}
BY_NAME = {name.replace(" ", "_").lower(): number for number, name in POWER_SUPPLY_STATUS.items()}


class EventPrinter:
    """Prints events for a person, without feedback that reads as the one before it; or as JSON, all of them.

    Args:
        as_json: Whether as JSON.
    """

    def __init__(self, *, as_json: bool) -> None:
        self._as_json = as_json
        self._feedback: dict[str, list[str]] = {}  # of goals that run: the last lines

    def show(self, event: dict[str, Any]) -> None:
        """Print an event."""
        kind, goal_id = event["type"], event.get("goal_id", "")
        if kind == "heartbeat":
            return
        lines = [orjson.dumps(event).decode()] if self._as_json else lines_of(event)
        if kind == "result":
            self._feedback.pop(goal_id, None)
        elif kind == "feedback" and not self._as_json:
            if self._feedback.get(goal_id) == lines:
                return
            self._feedback[goal_id] = lines
        for line in lines:
            click.echo(line)


def lines_of(event: dict[str, Any]) -> list[str]:
    """Return what a person reads about an event; nothing if it is of no interest."""
    kind, goal_id = event["type"], event.get("goal_id", "")[:8]
    match kind:
        case "snapshot":
            running = [goal for goal in event["goals"] if not goal["finished_at"]]
            return [_line_of(goal) for goal in running or event["goals"][:1]]
        case "status":
            running = event["status"] == "executing" and event["stage"]
            stage = f", {event['stage'].lower().replace('_', ' ')}" if running else ""
            error = f": {event['error']['detail']}" if event["error"] else ""
            return [printable(f"{goal_id} {event['status']}{stage}{error}")]
        case "feedback":
            return [printable(f"{goal_id} feedback {describe(event['feedback'])}")]
        case "result":
            return [printable(f"{goal_id} result {describe(event['result'] or {})}")]
        case "dropped" | "closing":
            return [orjson.dumps(event).decode()]
        case _:
            return []


def _line_of(goal: dict[str, Any]) -> str:
    origin = "" if goal["origin"] == "gateway" else f" ({goal['origin']})"
    return f"{goal['goal_id'][:8]} {goal['status']}{origin}"


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
        parts.append(f"{state['voltage']:.3g} V")
    return ", ".join(parts)
