"""The tokens that `dock-gateway login` has stored: a file that only its owner can read."""

import json
import os
from pathlib import Path

import click
import platformdirs

from dock_gateway.client.connection import URL

TOKEN = "DOCK_GATEWAY_TOKEN"  # noqa: S105 - the name of a variable


def token_file() -> Path:
    """Return the file, which need not be there."""
    return platformdirs.user_config_path("dock-gateway", appauthor=False) / "tokens.json"


def address_of(url: str | None) -> str:
    """Return the address under which the token of a gateway is stored."""
    return (url or os.environ.get("DOCK_GATEWAY_URL") or URL).rstrip("/")


def stored_token(url: str | None) -> str | None:
    """Return the token for a gateway; None if DOCK_GATEWAY_TOKEN has one, or none is stored.

    Raises:
        click.ClickException: The file cannot be read.
    """
    if os.environ.get(TOKEN):
        return None
    return _read().get(address_of(url))


def store_token(url: str | None, token: str | None) -> bool:
    """Store a token for a gateway, or forget it. Return whether there was one.

    Raises:
        click.ClickException: The file cannot be written.
    """
    tokens, path = _read(), token_file()
    had = tokens.pop(address_of(url), None) is not None
    if token is not None:
        tokens[address_of(url)] = token
    elif not had:
        return False
    fresh = path.with_name(f"{path.name}.new")
    try:
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        fresh.unlink(missing_ok=True)
        with os.fdopen(os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:
            json.dump(tokens, file, indent=2)
        fresh.replace(path)
    except OSError as error:
        raise click.ClickException(f"{path} cannot be written: {error.strerror}") from None
    return had


def _read() -> dict[str, str]:
    path = token_file()
    try:
        found = json.loads(path.read_text())
    except FileNotFoundError:
        return {}
    except (OSError, ValueError) as error:
        raise click.ClickException(f"{path} cannot be read: {error}") from None
    return {str(url): str(token) for url, token in found.items()} if isinstance(found, dict) else {}
