"""`dock-gateway serve`: the gateway alone; `dock-gateway openapi` and `asyncapi`: the documents of its API.

The server takes seconds to import. It is imported where it runs, so that client commands do not wait for it.
"""

import os
from typing import Any

import click
import orjson

from dock_gateway.cli.options import read_settings, settings_options
from dock_gateway.cli.start import check_start, load_ros
from dock_gateway.settings import Settings

# What the variables begin with that ROS and DDS read.
ROS_PREFIXES = ("ROS_", "RMW_", "FASTDDS_", "FASTRTPS_", "CYCLONEDDS_", "ZENOH_")


@click.command()
@settings_options
def serve(**options: str | None) -> None:
    """Run only the gateway, for action servers that run already."""
    settings = read_settings(options)
    check_start(settings, os.environ)
    load_ros(os.environ)
    from dock_gateway.cli.gateway import run_gateway  # noqa: PLC0415
    from dock_gateway.core.errors import GatewayError  # noqa: PLC0415
    from dock_gateway.http.edge.certificates import CertificateError  # noqa: PLC0415 - see above

    variables = " ".join(sorted(name for name in os.environ if name.startswith(ROS_PREFIXES)))
    try:
        started = run_gateway(settings)
    except CertificateError as error:
        raise click.UsageError(str(error)) from None
    except GatewayError as error:
        advice = "" if error.code == "robots_claimed" else f"; check {variables or 'the network'}"
        raise click.ClickException(f"{error.detail}{advice}") from None
    if not started:
        raise SystemExit(1)


@click.command()
@click.option("--hub", is_flag=True, help="That of a hub.")
def openapi(*, hub: bool) -> None:
    """Print the OpenAPI document: requests and answers."""
    if not hub:
        _print(_openapi())
        return
    from dock_gateway.hub.app import create_hub_app  # noqa: PLC0415 - see above

    _print(create_hub_app(Settings()).openapi())


@click.command()
def asyncapi() -> None:
    """Print the AsyncAPI document: streams, and the commands of /ws."""
    document = _openapi()
    from dock_gateway.streams.asyncapi import asyncapi_document  # noqa: PLC0415 - see above

    _print(asyncapi_document(document))


def _openapi() -> dict[str, Any]:
    try:
        from dock_gateway.app import create_app  # noqa: PLC0415 - see above
    except ModuleNotFoundError as error:
        raise click.ClickException(f"a gateway's documents describe ROS messages, which need ROS: {error}") from None
    return create_app(Settings()).openapi()


def _print(document: dict[str, Any]) -> None:
    click.echo(orjson.dumps(document, option=orjson.OPT_INDENT_2).decode())
