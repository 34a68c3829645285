"""The real hub as a process, and gateways that are its sites."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx2
import orjson
from websockets.sync.client import ClientConnection

from dock_gateway.sites.identity import Signer
from tests.support.clients import open_websocket
from tests.support.processes import ForkedProcess, Process, ros_environment
from tests.support.waiting import PATIENCE, wait_until


@dataclass
class RunningHub:
    """A hub, its address and an HTTP client for it."""

    process: Process
    url: str
    http: httpx2.Client

    def get(self, path: str) -> Any:
        """Return the document at a path."""
        return self.http.get(path).raise_for_status().json()

    def wait_for_site(self, name: str, state: str = "connected") -> dict[str, Any]:
        """Wait until a site is in a state and nothing of it is missing; return it."""

        def found() -> dict[str, Any]:
            sites = {site["name"]: site for site in self.get("/sites")["sites"]}
            site = sites.get(name, {"state": None})
            return site if site["state"] == state and not site["behind"] else {}

        return wait_until(found, f"{name} is {state}")

    def wait_for_goal(self, goal_id: str, *statuses: str) -> dict[str, Any]:
        """Wait until the hub has a goal in one of these states."""

        def found() -> dict[str, Any]:
            answer = self.http.get(f"/goals/{goal_id}")
            goal = answer.json()
            return goal if answer.status_code == 200 and goal["status"] in statuses else {}

        return wait_until(found, f"goal {goal_id} is one of {statuses}")

    @contextmanager
    def stream(self, path: str) -> Iterator[ClientConnection]:
        """Open a WebSocket."""
        url = self.url.replace("http", "ws") + path
        with open_websocket(url, max_size=None) as connection:
            yield connection


def until_event(connection: ClientConnection, **wanted: Any) -> dict[str, Any]:
    """Read on to the first event that has these fields."""
    while True:
        event: dict[str, Any] = orjson.loads(connection.recv(PATIENCE))
        if all(event.get(name) == value for name, value in wanted.items()):
            return event


@contextmanager
def running_hub(nats: str, folder: Path, **settings: str) -> Iterator[RunningHub]:
    """`dock-gateway hub` on a free port, with its key and its database in a folder."""
    kept = {"database_url": f"sqlite:///{folder}/hub.db", "spool_path": f"{folder}/hub-spool"}
    kept |= {"hub_private_key": f"{folder}/hub.key", "nats": nats, "port": "0"}
    variables = {f"DOCK_GATEWAY_{name.upper()}": value for name, value in (kept | settings).items()}
    with ForkedProcess("dock-gateway", "hub", env=ros_environment(0, **variables)) as process:
        url = re.sub(r'.*(https?://[^"]+).*', r"\1", process.wait_for("listening on "))
        with httpx2.Client(base_url=url, trust_env=False, timeout=PATIENCE) as http:
            yield RunningHub(process, url, http)


def site_settings(nats: str, folder: Path, name: str) -> dict[str, str]:
    """What a gateway needs to be a site of the hub of a folder; its history outlives its process."""
    keys = folder / "hub.json"
    keys.write_bytes(orjson.dumps(Signer.load_or_create(folder / "hub.key").public_keys()))
    kept = {"database_url": f"sqlite:///{folder}/{name}.db", "spool_path": f"{folder}/{name}-spool"}
    return {"nats": nats, "site": name, "hub_public_keys": str(keys), **kept}
