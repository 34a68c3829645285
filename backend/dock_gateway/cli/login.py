"""`dock-gateway login` and `logout`: the token with which the other commands ask a gateway."""

import sys

import click

from dock_gateway.cli.asking import wanted
from dock_gateway.cli.shared_options import url_option
from dock_gateway.cli.stored_tokens import address_of, store_token, token_file
from dock_gateway.client import Client, ClientError
from dock_gateway.core.log_config import printable


@click.command()
@url_option
def login() -> None:
    """Store a token for a gateway, which is asked for or read from the input.

    The other commands use it for this address, unless DOCK_GATEWAY_TOKEN has another one. `dock-gateway token create`
    or the page Access makes a token. The file can only be read by you.
    """
    url = wanted("url")
    if sys.stdin.isatty():
        token: str = click.prompt(f"Token for {address_of(url)}", hide_input=True)
    else:
        token = sys.stdin.readline()
    if not (token := token.strip()):
        raise click.UsageError("the token is empty")
    try:
        with Client(url, token=token) as client:
            session = client.request("GET", "/session")
    except ClientError as error:
        raise click.ClickException(printable(str(error))) from None
    if session["principal"] is None:
        raise click.ClickException(f"{address_of(url)} does not accept this token")
    if not session["required"]:
        raise click.ClickException(f"{address_of(url)} asks for no login: no token is needed")
    store_token(url, token)
    who = session["principal"]
    click.echo(printable(f"logged in at {address_of(url)} as {who['name']} ({who['role']}); stored in {token_file()}"))


@click.command()
@url_option
def logout() -> None:
    """Forget the token for a gateway. It stays valid: `dock-gateway token delete` ends that."""
    url = wanted("url")
    click.echo("the token is forgotten" if store_token(url, None) else f"there is no token for {address_of(url)}")
