"""`dock-gateway api`: any request of docs/api.md."""

from typing import Any
from urllib.parse import parse_qsl

import click
import orjson

from dock_gateway.cli.asking import asks, gateway, print_json, wanted

METHODS = ("GET", "HEAD", "POST", "PUT", "PATCH", "DELETE")


@click.command()
@click.argument("target", metavar="[METHOD] PATH", nargs=-1, required=True)
@click.option(
    "-f",
    "--field",
    "fields",
    multiple=True,
    metavar="NAME=VALUE",
    help="A field: of the query with GET and DELETE, else of the body, where the value may be JSON. May be repeated.",
)
@click.option("--body", metavar="JSON", help="The whole body.")
@click.option("--wait", type=click.IntRange(0), default=0, help="Seconds that the gateway may wait for a goal's end.")
@asks
def api(target: tuple[str, ...], fields: tuple[str, ...], body: str | None, wait: int) -> None:
    """Send any request, and print the answer, which is JSON.

    For example: dock-gateway api /statistics -f by=robot
    """
    method, path = target if len(target) == 2 else ("GET", target[0])
    if len(target) > 2 or method.upper() not in METHODS:
        raise click.UsageError(f"write a method ({', '.join(METHODS)}) and a path, or only a path")
    path, _, asked = path.partition("?")
    query: dict[str, Any] = {}
    document: Any = None if body is None else _parse_body(body)
    for name, value in (*parse_qsl(asked, keep_blank_values=True), *map(_pair, fields if _in_query(method) else ())):
        query[name] = [*query[name], value] if name in query else [value]
    if not _in_query(method) and fields:
        if document is not None:
            raise click.UsageError("--body is the whole body: leave out --field, or the other way round")
        document = {name: _value(value) for name, value in map(_pair, fields)}
    with gateway() as client:
        answer = client.request(method.upper(), f"/{path.lstrip('/')}", document, params=query, wait=wait)
    if wanted("as_json"):
        print_json(answer)
    elif answer is not None:
        click.echo(orjson.dumps(answer, option=orjson.OPT_INDENT_2))


def _in_query(method: str) -> bool:
    return method.upper() in ("GET", "HEAD", "DELETE")


def _pair(field: str) -> tuple[str, str]:
    name, found, value = field.partition("=")
    if not found or not name:
        raise click.UsageError(f"{field!r} is not like dock_id=lab")
    return name, value


def _value(text: str) -> object:
    """Return a value of the body: what is JSON, or else the text."""
    try:
        return orjson.loads(text)
    except orjson.JSONDecodeError:
        return text


def _parse_body(text: str) -> object:
    try:
        return orjson.loads(text)
    except orjson.JSONDecodeError as error:
        raise click.UsageError(f"--body is not JSON: {error}") from None
