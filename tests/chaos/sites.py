"""A hub, a NATS server and simulated sites, each of which can be killed, and whose connections misbehave."""

import contextlib
import itertools
import json
import signal
import sys
import threading
import time
import uuid
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Self

import httpx2
import orjson
from websockets.sync.client import ClientConnection

from dock_gateway.sites.identity import Signer
from tests.chaos.load import Reader, Worker
from tests.support.clients import open_websocket
from tests.support.link import Link, link_to
from tests.support.processes import ForkedProcess, Process, free_port, ros_environment
from tests.support.site_broker import SiteBroker
from tests.support.waiting import wait_until

# Seconds by which the clocks of the sites are ahead of the hub's.
CLOCKS = {"berlin": 3600.0, "oslo": -3600.0, "lyon": 0.0}
# A share of messages in each direction of each connection.
DUPLICATED, REORDERED = 0.02, 0.002


def plain_client(url: str, timeout: float = 20.0) -> httpx2.Client:
    """A client that compares nothing with the OpenAPI document of a gateway."""
    return httpx2.Client(base_url=url, timeout=timeout, trust_env=False)


class Sites:
    """All of it. The broker, the hub and the sites are started at once, and ended with the block."""

    def __init__(
        self,
        folder: Path,
        sites: dict[str, float] = CLOCKS,
        robots: int = 3,
        *,
        duplicated: float = DUPLICATED,
        reordered: float = REORDERED,
    ) -> None:
        self.names = list(sites)
        self.folder = folder
        self._misbehave = {"duplicated": duplicated, "reordered": reordered}
        self._clocks = sites
        self._robots = robots
        self._port = free_port()
        self.url = f"http://127.0.0.1:{self._port}"
        self._stack = ExitStack()
        self.broker = SiteBroker(folder, *sites)
        self.links: dict[str, Link] = {}
        self._processes: dict[str, Process] = {}
        self.outputs: list[Process] = []

    def __enter__(self) -> Self:
        keys = Signer.load_or_create(self.folder / "hub-key.json").public_keys()
        (self.folder / "keys.json").write_text(json.dumps(keys))
        self.broker.start()
        self._stack.callback(self.broker.kill)
        for number, name in enumerate(("hub", *self.names)):
            link = link_to(self.broker, **self._misbehave, seed=number)
            self.links[name] = self._stack.enter_context(link)
        for name in ("hub", *self.names):
            self.start(name)
        return self

    def __exit__(self, *_: object) -> None:
        for process in self._processes.values():
            process.send_signal(signal.SIGKILL)
            process.__exit__()
        self._stack.close()

    def start(self, name: str) -> None:
        """Start the hub or a site."""
        url = self.broker.url_for(name, self.links[name].port)
        process: Process
        if name == "hub":
            settings = {
                "port": str(self._port),
                "nats": url,
                "hub_private_key": str(self.folder / "hub-key.json"),
                "database_url": f"sqlite:///{self.folder}/hub.db",
                "spool_path": str(self.folder / "hub-spool"),
                "max_subscribers": "100",
            }
            variables = {f"DOCK_GATEWAY_{key.upper()}": value for key, value in settings.items()}
            process = ForkedProcess("dock-gateway", "hub", env=ros_environment(0, **variables))
        else:
            (self.folder / f"{name}.json").write_text(json.dumps({name: url}))
            command = (sys.executable, "-m", "tests.extensions.sites.simulated_site", *self._arguments(name))
            process = Process(*command, env=ros_environment(0))
        self._processes[name] = process
        self.outputs.append(process)

    def _arguments(self, name: str) -> tuple[str, ...]:
        folder = self.folder
        return (
            *("--brokers", f"{folder}/{name}.json", "--keys", f"{folder}/keys.json", "--robots", str(self._robots)),
            *("--journals", str(folder), f"--clock-offset={self._clocks[name]}", name),
        )

    def kill(self, name: str) -> None:
        """Kill the hub or a site."""
        process = self._processes.pop(name)
        process.send_signal(signal.SIGKILL)
        process.wait()
        process.__exit__()

    def process(self, name: str) -> Process:
        """The process of the hub or a site."""
        return self._processes[name]

    def instance(self, site: str) -> str:
        """The id of the process of a site."""
        with plain_client(self.url) as http:
            instance: str = http.get(f"/sites/{site}").json()["instance"]
        return instance

    def followed(self) -> set[str]:
        """The sites that the hub has read once and hears now; none while there is no hub."""
        with contextlib.suppress(httpx2.HTTPError), plain_client(self.url, timeout=5.0) as http:
            sites = http.get("/sites").json()["sites"]
            return {site["name"] for site in sites if site["state"] == "connected" and site["cursor"] is not None}
        return set()

    def wait_for_all(self) -> None:
        """Wait until the hub follows all sites: from then on, each end is told."""
        wait_until(lambda: self.followed() == set(self.names), "all sites")

    def journal(self, site: str) -> list[dict[str, Any]]:
        """What a site has stored."""
        lines = (self.folder / f"{site}.jsonl").read_bytes().splitlines()
        entries = []
        for line in lines:
            with contextlib.suppress(orjson.JSONDecodeError):
                entries.append(orjson.loads(line))
        return entries

    def goals(self, site: str) -> dict[str, dict[str, Any]]:
        """The goals of a site, as they are there."""
        return {entry["goal"]["goal_id"]: entry["goal"] for entry in self.journal(site) if "goal" in entry}

    def executed(self, site: str) -> Counter[int]:
        """How often each command was carried out."""
        return Counter(entry["number"] for entry in self.journal(site) if entry.get("number") is not None)

    def latched(self, site: str) -> bool:
        """Whether the site holds a stop."""
        return bool(next((entry["stops"] for entry in reversed(self.journal(site)) if "stops" in entry), None))


class Commander(Worker):
    """Sends goals to one site through the hub: each second one with a key, until it is accepted; the others once."""

    numbers = itertools.count(1)

    def __init__(self, sites: Sites, site: str) -> None:
        super().__init__(f"commander of {site}")
        self._sites = sites
        self._site = site
        self.accepted: dict[int, str] = {}
        self.answers: Counter[str] = Counter()

    def turn(self) -> None:
        number = next(self.numbers)
        headers = {"Idempotency-Key": str(uuid.uuid4())} if number % 2 else {}
        while True:
            answer = self._send(number, headers)
            if not headers or number in self.accepted or self.stopping.is_set():
                break
            time.sleep(0.1)
        time.sleep(0.02 if answer else 0.1)

    def _send(self, number: int, headers: dict[str, str]) -> bool:
        try:
            with plain_client(self._sites.url) as http:
                path = f"/sites/{self._site}/dock?robot=/robot{number % 3 + 1}"
                answer = http.post(path, json={"number": number, "seconds": 0.05}, headers=headers)
        except httpx2.HTTPError:
            self.answers["broken off"] += 1
            return False
        document = answer.json()
        self.answers[document.get("code", str(answer.status_code))] += 1
        if answer.status_code != 202:
            return False
        self.accepted[number] = document["goal_id"]
        return True


@contextlib.contextmanager
def commanders(sites: Sites, each: int = 2) -> Iterator[list[Commander]]:
    """Clients that send goals to all sites within the block."""
    workers = [Commander(sites, site) for site in sites.names for _ in range(each)]
    for worker in workers:
        worker.start()
    try:
        yield workers
    finally:
        for worker in workers:
            worker.stopping.set()


class Stopper(threading.Thread):
    """Presses Stop for a site once at the hub, as a person does: again until the hub has taken it."""

    def __init__(self, url: str, site: str) -> None:
        super().__init__(name=f"stop of {site}", daemon=True)
        self._url = url
        self.site = site
        self.code = ""

    def run(self) -> None:
        while not self.code:
            with contextlib.suppress(httpx2.HTTPError), plain_client(self._url) as http:
                answer = http.post(f"/stop?robot=/{self.site}")
                self.code = answer.json().get("code", str(answer.status_code))
            time.sleep(0.1)


class HubReader(Reader):
    """Reads every event of the hub, and resumes after the last one."""

    def connect(self, url: str) -> ClientConnection:
        return open_websocket(url, max_size=None, open_timeout=5, proxy=None)
