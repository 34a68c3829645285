"""The Compose files: the gateway knows where its port is published, and who else is on its network."""

from pathlib import Path
from typing import Any

import yaml

ROOT = Path(__file__).parents[2]


class Loader(yaml.SafeLoader):
    """Reads Compose's `!reset`, too."""


Loader.add_constructor("!reset", lambda loader, node: loader.construct_sequence(node))


def services(name: str) -> dict[str, Any]:
    found: dict[str, Any] = yaml.load((ROOT / name).read_text(), Loader)["services"]
    return found


DEFAULT, ON_HOST = services("docker-compose.yml"), services("docker-compose.host.yml")


def test_the_gateway_is_told_where_its_port_is_published() -> None:
    """So that it refuses to be open to a network, whatever address its container listens on."""
    (published,) = DEFAULT["network"]["ports"]
    address = published.removesuffix(":${DOCK_GATEWAY_PORT:-8000}:8000")
    assert address == "${DOCK_GATEWAY_PUBLISHED_ON:-127.0.0.1}"
    environment = DEFAULT["gateway"]["environment"]
    assert environment["DOCK_GATEWAY_PUBLISHED_ON"] == address
    assert environment["DOCK_GATEWAY_INSECURE_OPEN"] == "${DOCK_GATEWAY_INSECURE_OPEN:-false}"


def test_on_the_network_of_the_host_its_own_address_counts() -> None:
    assert ON_HOST["network"]["ports"] == []
    assert ON_HOST["gateway"]["environment"]["DOCK_GATEWAY_PUBLISHED_ON"] == ""
    assert ON_HOST["gateway"]["environment"]["DOCK_GATEWAY_HOST"] == "${DOCK_GATEWAY_HOST:-127.0.0.1}"


def test_who_else_is_on_its_bridge() -> None:
    """As docs/deployment.md says: they reach its port without a login."""
    assert {name for name, service in DEFAULT.items() if "network_mode" not in service} == {"network", "grafana"}
