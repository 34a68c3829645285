"""`dock-gateway dock`, `undock`, `cancel`, `stop`, `release`, `watch`, `battery`: a client of a running gateway."""

import os
import ssl
import sys
import uuid
from collections.abc import Iterator, Mapping
from typing import Any
from urllib.parse import urlencode, urlsplit

import click
import httpx2
import orjson
from websockets.exceptions import ConnectionClosed, InvalidHandshake, InvalidURI
from websockets.sync.client import connect

from dock_gateway.core.log_config import printable
from dock_gateway.setting_types import LOOPBACK_HOSTS

TIMEOUT = 15.0
TERMINAL = ("succeeded", "canceled", "aborted", "rejected", "lost")
POWER_SUPPLY_STATUS = {0: "UNKNOWN", 1: "CHARGING", 2: "DISCHARGING", 3: "NOT CHARGING", 4: "FULL"}
BY_NAME = {name.replace(" ", "_").lower(): number for number, name in POWER_SUPPLY_STATUS.items()}

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


def on_this_machine(url: str) -> bool:
    """Whether a gateway is on this machine, so that no proxy is used."""
    try:
        return (urlsplit(url).hostname or "") in LOOPBACK_HOSTS
    except ValueError:
        return False


def authorization() -> dict[str, str]:
    """Return the header with the token in DOCK_GATEWAY_TOKEN, if there is one.

    There is no option for it: other users of the machine can read command lines.
    """
    secret = os.environ.get("DOCK_GATEWAY_TOKEN")
    return {"Authorization": f"Bearer {secret}"} if secret else {}


def tls_context(url: str) -> ssl.SSLContext | None:
    """Return how an https:// address is connected to; None for others.

    The authorities are those of the system, or those in the file SSL_CERT_FILE. DOCK_GATEWAY_CLIENT_CERT is a file
    with a certificate and its key, for a gateway that asks for one.

    Raises:
        click.ClickException: That file cannot be used.
    """
    if not url.lower().startswith("https:"):
        return None
    context = ssl.create_default_context()
    if path := os.environ.get("DOCK_GATEWAY_CLIENT_CERT"):
        try:
            context.load_cert_chain(path)
        except OSError as error:
            raise click.ClickException(f"DOCK_GATEWAY_CLIENT_CERT: {path} cannot be used: {error}") from None
    return context


def robot_query(robot: str | None) -> str:
    """Return the query that names a robot."""
    return "" if robot is None else f"?{urlencode({'robot': robot})}"


def call(url: str, method: str, path: str, body: object = None, headers: Mapping[str, str] | None = None) -> Any:
    """Send a request and return the decoded answer.

    Raises:
        click.ClickException: The gateway does not answer, or refuses. The message says why.
    """
    try:
        response = httpx2.request(
            method,
            f"{url.rstrip('/')}{path}",
            content=None if body is None else orjson.dumps(body),
            headers={
                **({} if body is None else {"Content-Type": "application/json"}),
                **authorization(),
                **(headers or {}),
            },
            timeout=TIMEOUT,
            trust_env=not on_this_machine(url),
            verify=tls_context(url) or True,
        )
    except (httpx2.TransportError, httpx2.InvalidURL) as error:
        raise click.ClickException(
            f"no gateway answers at {url} ({error}); "
            "start one with `dock-gateway up`, or name another with --url or DOCK_GATEWAY_URL"
        ) from None
    try:
        answer = orjson.loads(response.content) if response.content else None
    except orjson.JSONDecodeError:
        raise click.ClickException(f"{url} is not a dock-gateway") from None
    if response.is_error:
        answer = answer if isinstance(answer, dict) else {}
        code, detail = answer.get("code", response.status_code), answer.get("detail", "no reason given")
        raise click.ClickException(printable(f"{code}: {detail}"))
    return answer


def events(url: str, query: str) -> Iterator[dict[str, Any]]:
    """Yield the events of a stream until it ends.

    Raises:
        click.ClickException: The stream could not be opened, or broke.
    """
    address = f"{url.rstrip('/').replace('http', 'ws', 1)}/ws/feedback{query}"
    try:
        with connect(
            address,
            max_size=None,
            proxy=None if on_this_machine(url) else True,
            ssl=tls_context(url),
            additional_headers=authorization(),
        ) as stream:
            for message in stream:
                yield orjson.loads(message)
    except InvalidHandshake as error:
        raise click.ClickException(f"the gateway refused the stream: {error}") from None
    except (ConnectionClosed, OSError) as error:
        raise click.ClickException(f"the stream ended: {error}") from None
    except (InvalidURI, ValueError) as error:  # a certificate that is refused is an OSError, too
        raise click.ClickException(f"{url} is not the address of a gateway: {error}") from None


def show(event: dict[str, Any], *, as_json: bool) -> None:
    """Print an event for a person, or as JSON."""
    if as_json:
        click.echo(orjson.dumps(event))
        return
    kind, goal_id = event["type"], event.get("goal_id", "")[:8]
    if kind == "snapshot":
        running = [goal for goal in event["goals"] if goal["status"] not in TERMINAL]
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


def follow(url: str, goal_id: str, *, as_json: bool) -> dict[str, Any]:
    """Show a goal's events until it ends. Return the goal."""
    for event in events(url, f"?goal_id={goal_id}"):
        if event["type"] != "heartbeat":
            show(event, as_json=as_json)
        if event["type"] == "snapshot" and event["goals"][0]["status"] in TERMINAL:
            break
        if event["type"] == "result" or event.get("status") in ("rejected", "lost"):
            break
    goal: dict[str, Any] = call(url, "GET", f"/goals/{goal_id}")
    return goal


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
    send(url, "/dock", {"desired_battery_state": state}, no_wait=no_wait, as_json=as_json)


@click.command()
@click.option("--no-wait", is_flag=True, help="Do not wait for the end; print the goal id.")
@json_option
@url_option
def undock(url: str, no_wait: bool, as_json: bool) -> None:
    """Drive the robot off its charging dock and show its feedback. Ctrl-C cancels the goal."""
    send(url, "/undock", {}, no_wait=no_wait, as_json=as_json)


def send(url: str, path: str, body: dict[str, Any], *, no_wait: bool, as_json: bool) -> None:
    """Send a goal and show its events until it ends. Exit with 1 unless it succeeded."""
    headers = {"Idempotency-Key": str(uuid.uuid4())}
    goal: dict[str, Any] | None = None
    try:
        goal = call(url, "POST", path, body, headers)
        if no_wait:
            click.echo(orjson.dumps(goal) if as_json else goal["goal_id"])
            return
        if not as_json:
            click.echo(f"goal {goal['goal_id']} accepted")
        goal = follow(url, goal["goal_id"], as_json=as_json)
    except KeyboardInterrupt:
        click.echo("canceling …", err=True)
        if goal is None:  # it may have been sent already: the same key returns it
            goal = call(url, "POST", path, body, headers)
        call(url, "POST", f"{path}/{goal['goal_id']}/cancel")
        goal = follow(url, goal["goal_id"], as_json=as_json)
    if goal["status"] != "succeeded":
        sys.exit(1)


@click.command()
@click.argument("goal_id", required=False)
@url_option
def cancel(url: str, goal_id: str | None) -> None:
    """Cancel a goal; without GOAL_ID, the running one."""
    if goal_id is None:
        query = "&".join(f"status={status}" for status in ("pending", "accepted", "executing", "canceling"))
        running = [goal for path in ("/dock", "/undock") for goal in call(url, "GET", f"{path}?{query}")["goals"]]
        if not running:
            raise click.ClickException("no goal is running")
        goal_id = running[0]["goal_id"]
    goal = call(url, "POST", f"/goals/{goal_id}/cancel")
    click.echo(f"goal {goal['goal_id']} {goal['status']}")


@click.command()
@click.option("--by", help="Your name, shown to others.")
@click.option("--no-latch", is_flag=True, help="Accept new goals again immediately.")
@click.option(
    "--robot", "robots", multiple=True, help="Namespace of a robot, such as /robot1; several to stop several."
)
@url_option
def stop(url: str, robots: tuple[str, ...], no_latch: bool, by: str | None) -> None:
    """Stop the robot: zero velocity, every goal is canceled, and none is sent until `dock-gateway release`."""
    body = {"latch": not no_latch, "by": by}
    query = f"?{urlencode({'robot': robots}, doseq=True)}" if robots else ""
    report = call(url, "POST", f"/stop{query}", body, {"Prefer": "wait=2"})
    click.echo(f"zero velocity published; canceling {', '.join(report['canceling']) or 'no goal'}")
    if warning := report.get("warning"):
        click.echo(printable(f"warning: {warning['detail']}"), err=True)
    if report["stop"]["latched"]:
        click.echo("goals are refused until the stop is released: dock-gateway release")
    for failure in report["failed"]:
        click.echo(printable(f"{failure['action_name'] or failure['robot']}: {failure['detail']}"), err=True)
    for name in report["unconfirmed"]:
        click.echo(f"{name}: the action server has not answered yet", err=True)
    if report["failed"] or report["unconfirmed"]:
        sys.exit(1)


@click.command()
@robot_option
@url_option
def release(url: str, robot: str | None) -> None:
    """Release a stop: new goals are accepted again. The robot stays where it is."""
    call(url, "DELETE", f"/stop{robot_query(robot)}")
    click.echo("released")


@click.command()
@click.argument("goal_id", required=False)
@json_option
@url_option
def watch(url: str, goal_id: str | None, as_json: bool) -> None:
    """Show events as they happen: of every goal, or of GOAL_ID until it has ended."""
    try:
        if goal_id is not None:
            follow(url, goal_id, as_json=as_json)
            return
        for event in events(url, ""):
            show(event, as_json=as_json)
    except KeyboardInterrupt:
        pass


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
    if stop_publishing:
        call(url, "DELETE", "/battery/publisher")
        click.echo("publishing has stopped")
    elif status is None:
        if voltage is not None or percentage is not None or rate is not None:
            raise click.UsageError("--status is needed to publish a battery state")
        answer = call(url, "GET", "/battery")
        if answer["state"] is None:
            others = ", ".join(answer.get("other_topics", ()))
            click.echo(f"no battery state yet{f'; there are batteries on {others}' if others else ''}")
        else:
            click.echo(f"{describe(answer)} ({answer['age_s']:.1f} s ago{', stale' if answer['stale'] else ''})")
            for wrong in answer.get("implausible", ()):
                click.echo(f"not used: {wrong['field']} is {wrong['value']}, but should be {wrong['expected']}")
    else:
        state = {"power_supply_status": status, "voltage": voltage, "percentage": percentage}
        if rate is None:
            call(url, "POST", "/battery", state)
        else:
            call(url, "PUT", "/battery/publisher", {"state": state, "rate_hz": rate})
        click.echo(
            f"published: {describe({'state': state})}" + (f", {rate:g} times a second from now on" if rate else "")
        )
