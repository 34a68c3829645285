"""`dock-gateway hub`: one dashboard and one API for many sites; `dock-gateway hub key`: its keys. Needs no ROS."""

import os
from functools import partial
from typing import Any

import click
import orjson

from dock_gateway.cli.options import CommandsWithSettings, read_again, read_settings_of, settings_options
from dock_gateway.cli.start import check_exposure, check_port
from dock_gateway.doctor.machine import find_database_fault
from dock_gateway.setting_groups.group import PREFIX
from dock_gateway.settings import data_file
from dock_gateway.sites.settings import find_broker_fault
from dock_hub.settings import HubSettings, hub_settings_type

# What a hub reads of the settings besides those of the web server, by what their names begin with.
OPTIONS = (
    *("host", "port", "allowed_", "log_", "authentication", "allow_open", "published_on", "tls_"),
    *("trusted_proxies", "dashboard_dir", "database_url", "spool_path", "history_queue"),
    *("feedback_retention_", "goal_retention_"),
    *("audit_", "max_body_bytes", "body_timeout", "max_header_bytes", "header_timeout", "max_connections"),
    *("max_frame", "max_subscribers", "max_streams_per_user", "max_goals_per_minute", "max_exports_per_user"),
    *("subscriber_", "heartbeat_interval", "nats", "allow_plain_nats", "hub_private_key"),
)


@click.group(cls=CommandsWithSettings, invoke_without_command=True)
@partial(
    settings_options,
    leave_out=[name for name in HubSettings.model_fields if not name.startswith(OPTIONS)],
    settings=hub_settings_type(),
)
def hub(**options: Any) -> None:
    """Run a hub: one dashboard, one API and one set of rights for many gateways, over NATS."""
    if click.get_current_context().invoked_subcommand is None:
        _run(_checked(options), options)


def _checked(options: dict[str, Any]) -> HubSettings:
    """Return the settings of a hub that can start."""
    settings = read_settings_of(hub_settings_type(), options)
    if not settings.nats:
        raise click.UsageError("a hub needs --nats, the NATS servers over which it reaches its sites")
    if os.environ.get(f"{PREFIX}SITE"):
        raise click.UsageError("a hub is not a site of another hub: leave out DOCK_GATEWAY_SITE")
    if settings.database_url == "memory:":
        raise click.UsageError("a hub needs a database, to know what it has read of its sites: not memory:")
    if not settings.database_url:  # a gateway on this machine has its own
        own: dict[str, Any] = {"database_url": f"sqlite:///{data_file('hub.db')}"}
        own |= {} if settings.spool_path else {"spool_path": data_file("hub-spool")}
        settings = settings.model_copy(update=own)
    check_exposure(settings)
    if (fault := find_broker_fault(settings)) is not None:
        raise click.UsageError(fault)
    check_port(settings)
    if (fault := find_database_fault(settings)) is not None:
        raise click.ClickException(fault)
    return settings


def _run(settings: HubSettings, options: dict[str, Any]) -> None:
    from dock_gateway.cli.server import run  # noqa: PLC0415 - takes long to import
    from dock_gateway.http.edge.certificates import CertificateError  # noqa: PLC0415
    from dock_gateway.sites.identity import KeyFault  # noqa: PLC0415
    from dock_hub.app import create_hub_app  # noqa: PLC0415
    from dock_hub.assembly import open_hub  # noqa: PLC0415
    from dock_hub.extensions import hub_extensions  # noqa: PLC0415

    reread = partial(read_again, hub_settings_type(), options)
    try:
        started = run(settings, partial(open_hub, installed=hub_extensions()), create_hub_app, reread=reread)
    except CertificateError as error:
        raise click.UsageError(str(error)) from None
    except KeyFault as error:
        raise click.ClickException(str(error)) from None
    if not started:
        raise SystemExit(1)


@hub.command()
@click.option("--hub-private-key", metavar="FILE", help="The private key.  [env: DOCK_GATEWAY_HUB_PRIVATE_KEY]")
def key(hub_private_key: str | None) -> None:
    """Print the hub's public keys, a JWK Set: what each of its sites needs as `--hub-public-keys`.

    Makes the private key if there is none yet.
    """
    from dock_gateway.sites.identity import KeyFault, Signer  # noqa: PLC0415 - takes long to import

    try:
        signer = Signer.load_or_create(read_settings_of(HubSettings, {"hub_private_key": hub_private_key}).hub_key_file)
    except KeyFault as error:
        raise click.ClickException(str(error)) from None
    click.echo(orjson.dumps(signer.public_keys(), option=orjson.OPT_INDENT_2).decode())
