"""The name of this machine and the address of this gateway for other gateways."""

import socket
from pathlib import Path

from dock_gateway.settings import Settings

# What `host` may be, and no other machine can use.
EVERY_ADDRESS = ("0.0.0.0", "::", "")  # noqa: S104


def host_name() -> str:
    """Return the name of this machine or container."""
    return socket.gethostname()


def boot_id() -> str:
    """Return a random id that the machine has had since it was started."""
    return Path("/proc/sys/kernel/random/boot_id").read_text().strip()


def own_address(settings: Settings, port: int) -> str:
    """Return where the gateway is; empty if the port is not chosen yet.

    Args:
        settings: The settings.
        port: Its port; 0: one that is free.
    """
    host = settings.published_on or settings.host
    if host in EVERY_ADDRESS:
        host = host_name()
    scheme = "https" if settings.tls else "http"
    return f"{scheme}://{f'[{host}]' if ':' in host else host}:{port}" if port else ""
