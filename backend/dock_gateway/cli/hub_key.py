"""`dock-gateway hub-key`: the public keys of a hub, for its sites."""

import click
import orjson

from dock_gateway.cli.options import read_settings
from dock_gateway.sites.identity import KeyFault, Signer


@click.command()
@click.option("--hub-key-path", metavar="FILE", help="The private key.  [env: DOCK_GATEWAY_HUB_KEY_PATH]")
def hub_key(hub_key_path: str | None) -> None:
    """Print the hub's public keys, a JWK Set: what each of its sites needs as `--hub-key`.

    Makes the private key if there is none yet.
    """
    try:
        signer = Signer.load_or_create(read_settings({"hub_key_path": hub_key_path}).hub_key_file)
    except KeyFault as error:
        raise click.ClickException(str(error)) from None
    click.echo(orjson.dumps(signer.public_keys(), option=orjson.OPT_INDENT_2).decode())
