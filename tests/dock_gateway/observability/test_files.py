"""What Prometheus and Grafana load is well-formed, and is where docker-compose.yml mounts it from."""

from pathlib import Path
from typing import Any

import orjson
import yaml

ROOT = Path(__file__).parents[3]
FOLDER = ROOT / "observability"
COMPOSE = yaml.safe_load((ROOT / "docker-compose.yml").read_text())["services"]


def load(name: str) -> Any:
    return yaml.safe_load((FOLDER / name).read_text())


def mounted(service: str) -> dict[str, Path]:
    """The files of the checkout by their places in a container."""
    parts = (volume.split(":") for volume in COMPOSE[service]["volumes"])
    return {place: ROOT / source for source, place, *_ in parts if source.startswith("./")}


def test_they_start_only_on_demand() -> None:
    assert {name for name, service in COMPOSE.items() if "metrics" in service.get("profiles", ())} == {
        "prometheus",
        "grafana",
    }


def test_every_mounted_file_exists() -> None:
    for service in ("prometheus", "grafana"):
        assert all(source.exists() for source in mounted(service).values())


def test_prometheus_finds_the_gateway_and_the_rules() -> None:
    places = mounted("prometheus")
    (rules,) = load("prometheus.yml")["rule_files"]
    assert places[f"/etc/prometheus/{rules}"] == FOLDER / "alerts.yml"
    (job,) = load("prometheus.yml")["scrape_configs"]
    assert (job["job_name"], job["metrics_path"]) == ("dock-gateway", "/metrics")
    assert COMPOSE["prometheus"]["network_mode"] == COMPOSE["gateway"]["network_mode"], "it scrapes 127.0.0.1"
    assert job["static_configs"] == [
        {"targets": [f"127.0.0.1:{COMPOSE['gateway']['environment']['DOCK_GATEWAY_PORT']}"]}
    ]


def test_each_rule_says_what_is_wrong() -> None:
    rules = [rule for group in load("alerts.yml")["groups"] for rule in group["rules"]]
    assert len({rule["alert"] for rule in rules}) == len(rules)
    for rule in rules:
        assert rule["labels"]["severity"] in ("critical", "warning")
        assert rule["annotations"]["summary"]


def test_grafana_finds_the_dashboard_and_prometheus() -> None:
    places = mounted("grafana")
    (provider,) = load("grafana/provider.yml")["providers"]
    assert places[provider["options"]["path"]] == FOLDER / "grafana" / "dashboards"
    (source,) = load("grafana/datasource.yml")["datasources"]
    assert source["url"].removeprefix("$") in COMPOSE["grafana"]["environment"]


def test_the_panels_do_not_overlap() -> None:
    dashboard = orjson.loads((FOLDER / "grafana" / "dashboards" / "dock-gateway.json").read_bytes())
    taken: set[tuple[int, int]] = set()
    for panel in dashboard["panels"]:
        at = panel["gridPos"]
        cells = {(x, y) for x in range(at["x"], at["x"] + at["w"]) for y in range(at["y"], at["y"] + at["h"])}
        assert not cells & taken, panel["title"]
        assert at["x"] + at["w"] <= 24
        taken |= cells
    assert len({panel["id"] for panel in dashboard["panels"]}) == len(dashboard["panels"])
