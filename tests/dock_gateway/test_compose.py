"""The Compose files: the gateway knows where its port is published, and who else is on its network."""

import re
from pathlib import Path
from typing import Any

import yaml

from dock_hub.demonstration import Login, broker_permissions

ROOT = Path(__file__).parents[2]


class Loader(yaml.SafeLoader):
    """Reads Compose's `!reset` and `!override`, too."""


for tag in ("!reset", "!override"):
    Loader.add_constructor(tag, lambda loader, node: loader.construct_sequence(node))


def services(name: str) -> dict[str, Any]:
    found: dict[str, Any] = yaml.load((ROOT / name).read_text(), Loader)["services"]
    return found


DEFAULT, ON_HOST = services("docker-compose.yml"), services("docker-compose.host.yml")
ON_POSTGRESQL, BEHIND_PROXY = services("docker-compose.postgresql.yml"), services("docker-compose.proxy.yml")
GATEWAYS = ("gateway", "gateway2")


def test_the_gateway_is_told_where_its_port_is_published() -> None:
    """So that it refuses to be open to a network, whatever address its container listens on."""
    (published,) = DEFAULT["network"]["ports"]
    address = published.removesuffix(":${DOCK_GATEWAY_PORT:-8000}:8000")
    assert address == "${DOCK_GATEWAY_PUBLISHED_ON:-127.0.0.1}"
    environment = DEFAULT["gateway"]["environment"]
    assert environment["DOCK_GATEWAY_PUBLISHED_ON"] == address
    assert environment["DOCK_GATEWAY_ALLOW_OPEN"] == "${DOCK_GATEWAY_ALLOW_OPEN:-false}"


def test_on_the_network_of_the_host_its_own_address_counts() -> None:
    assert ON_HOST["network"]["ports"] == []
    assert ON_HOST["gateway"]["environment"]["DOCK_GATEWAY_PUBLISHED_ON"] == ""
    assert ON_HOST["gateway"]["environment"]["DOCK_GATEWAY_HOST"] == "${DOCK_GATEWAY_HOST:-127.0.0.1}"


def test_who_else_is_on_its_bridge() -> None:
    """As docs/deployment.md says: they reach its port without a login."""
    on_bridge = {
        name
        for name, service in DEFAULT.items()
        if "network_mode" not in service and "default" in service.get("networks", ["default"])
    }
    assert on_bridge == {"network", "grafana", "hub"}


def test_only_the_gateways_reach_the_database() -> None:
    """By its socket, in a volume: it is on no network."""
    database = ON_POSTGRESQL["database"]
    assert database["network_mode"] == "none"
    assert "listen_addresses=" in database["command"]
    (sockets,) = (each for each in database["volumes"] if each.startswith("database-socket:"))
    name, user = database["environment"]["POSTGRES_DB"], database["environment"]["POSTGRES_USER"]
    for gateway in GATEWAYS:
        assert ON_POSTGRESQL[gateway]["volumes"] == [sockets]
        url = ON_POSTGRESQL[gateway]["environment"]["DOCK_GATEWAY_DATABASE_URL"]
        assert url == f"postgresql://{user}@/{name}?host={sockets.partition(':')[2]}"
    assert set(ON_POSTGRESQL) == {"database", *GATEWAYS}


def test_behind_the_proxy_no_one_passes_without_a_login() -> None:
    for gateway in GATEWAYS:
        environment = BEHIND_PROXY[gateway]["environment"]
        assert environment["DOCK_GATEWAY_HOST"] == environment["DOCK_GATEWAY_TRUSTED_PROXIES"] == "127.0.0.1"
        assert environment["DOCK_GATEWAY_AUTHENTICATION"] == "true"
    (published,) = BEHIND_PROXY["network"]["ports"]
    assert published.endswith(":443"), "the gateways' own ports are not published"
    assert BEHIND_PROXY["proxy"]["network_mode"] == DEFAULT["gateway2"]["network_mode"] == "service:network"


def test_the_second_gateway_starts_with_the_proxy_alone_and_has_files_of_its_own() -> None:
    assert DEFAULT["gateway2"]["profiles"] == ["never"]
    assert BEHIND_PROXY["gateway2"]["profiles"] == []
    first, second = (DEFAULT[gateway]["environment"] for gateway in GATEWAYS)
    for setting in ("PORT", "NODE_NAME", "SPOOL_PATH", "STOP_PATH"):
        assert second[f"DOCK_GATEWAY_{setting}"] != first.get(f"DOCK_GATEWAY_{setting}")
    assert ON_HOST["gateway2"]["environment"]["DOCK_GATEWAY_PORT"] == second["DOCK_GATEWAY_PORT"]


def test_the_proxy_and_prometheus_find_both_gateways() -> None:
    ports = [DEFAULT[gateway]["environment"]["DOCK_GATEWAY_PORT"] for gateway in GATEWAYS]
    targets = [f"127.0.0.1:{port}" for port in ports]
    upstreams = re.search(r"reverse_proxy (.*) \{", (ROOT / "proxy/Caddyfile").read_text())
    assert upstreams is not None
    assert upstreams[1].split() == targets
    assert "./proxy:/etc/caddy:ro" in BEHIND_PROXY["proxy"]["volumes"]
    config, token = (volume.split(":") for volume in BEHIND_PROXY["prometheus"]["volumes"])
    assert config[1] in {volume.split(":")[1] for volume in DEFAULT["prometheus"]["volumes"]}, "in place of the other"
    (job,) = yaml.safe_load((ROOT / config[0]).read_text())["scrape_configs"]
    assert job["static_configs"] == [{"targets": targets}]
    assert job["authorization"]["credentials_file"].startswith(f"{token[1]}/")


def test_sites_reach_their_broker_and_each_other_not() -> None:
    """Each has a network namespace and shared memory of its own. On their network are only the broker and the hub."""
    parts = ("gateway", "docking", "simulator")
    for site, other in (("berlin", "oslo"), ("oslo", "berlin")):
        for part in parts:
            service = DEFAULT[f"{site}-{part}"]
            assert service["network_mode"] == service["ipc"] == f"service:{site}"
            assert other not in str(service)
        assert DEFAULT[site]["networks"] == ["sites"]
        assert "ports" not in DEFAULT[site]
        environment = DEFAULT[f"{site}-gateway"]["environment"]
        assert environment["DOCK_GATEWAY_SITE"] == site
        assert environment["DOCK_GATEWAY_NATS"].startswith(f"nats://{site}:")
        assert f"{site}-gateway" in DEFAULT["hub"]["depends_on"]
    assert "ports" not in DEFAULT["nats"]
    assert DEFAULT["hub"]["ports"] == DEFAULT["network"]["ports"], "in place of the gateway"


def test_the_hub_takes_all_of_sites_with_it_and_nothing_else() -> None:
    of_sites = {name for name, service in DEFAULT.items() if service.get("profiles") == ["sites"]}
    started, new = set(), {"hub"}
    while new:
        started |= new
        new = {name for service in new for name in DEFAULT[service].get("depends_on", ())} - started
    assert started == of_sites


def test_the_broker_gives_the_rights_that_the_demonstration_has_with_the_passwords_that_are_used() -> None:
    config = yaml.load((ROOT / "docker-compose.yml").read_text(), Loader)["configs"]["nats"]["content"]
    names = ("hub", "berlin", "oslo")
    hub, *sites = (Login(name, f"${{{name.upper()}_PASSWORD:-{name}}}") for name in names)
    expected = broker_permissions(hub, sites)["users"]
    for name, found, user in zip(names, config.split("{user: ")[1:], expected, strict=True):
        permissions = user["permissions"]
        texts = [user["password"], *permissions["publish"], *permissions["subscribe"]]
        assert re.findall(r'"([^"]*)"', found) == texts
        setting = ("hub", "NATS") if name == "hub" else (f"{name}-gateway", "NATS")
        url = DEFAULT[setting[0]]["environment"][f"DOCK_GATEWAY_{setting[1]}"]
        assert url == f"nats://{name}:{user['password']}@nats:4222"
