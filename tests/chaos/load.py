"""Clients that go on whatever happens to the gateways: senders with idempotency keys, and a reader that resumes."""

import itertools
import threading
import time
import uuid
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Self

import httpx2
import orjson
from websockets.exceptions import ConnectionClosed, InvalidHandshake
from websockets.sync.client import ClientConnection

from tests.support.clients import HttpClient, connect

# Codes of goals that were never sent: a retry with their key gets another goal.
UNSENT = {"stopped", "action_server_unavailable", "ros_unavailable"}
FINAL = {"succeeded", "canceled", "aborted", "rejected"}
BROKEN = (OSError, TimeoutError, EOFError, ConnectionClosed, InvalidHandshake)


class Worker(threading.Thread):
    """Does something again and again until it is told to stop; what it raises is raised by `finish`."""

    def __init__(self, name: str) -> None:
        super().__init__(name=name, daemon=True)
        self.stopping = threading.Event()
        self.error: Exception | None = None

    def run(self) -> None:
        try:
            while not self.stopping.is_set():
                self.turn()
        except Exception as error:  # noqa: BLE001 - `finish` raises it
            self.error = error

    def turn(self) -> None:
        raise NotImplementedError

    def finish(self, timeout: float = 60.0) -> None:
        self.stopping.set()
        self.join(timeout)
        assert not self.is_alive(), f"{self.name} hangs"
        if self.error is not None:
            raise self.error


class Sender(Worker):
    """Sends goals, each under a key of its own, and retries until it has an answer that says what became of it."""

    numbers = itertools.count(1)

    def __init__(self, url: Callable[[], str]) -> None:
        super().__init__("sender")
        self._url = url
        self.going = threading.Event()  # clear: no further goal is sent
        self.going.set()
        self.number = 0  # of the goal that it sends
        self.accepted: dict[int, str] = {}
        self.answers: Counter[str] = Counter()

    def turn(self) -> None:
        if not self.going.wait(0.1):
            return
        number = self.number = next(self.numbers)
        key, ids = str(uuid.uuid4()), set()
        while number not in self.accepted:
            try:
                with HttpClient(self._url(), timeout=10.0) as http:
                    headers = {"Idempotency-Key": key}
                    answer = http.post("/actions/fibonacci/goals", json={"order": number}, headers=headers)
            except httpx2.HTTPError:
                self.answers["broken off"] += 1
                time.sleep(0.05)
                continue
            document = answer.json()
            self.answers[document.get("code", str(answer.status_code))] += 1
            if "goal_id" in document and document.get("code") not in UNSENT:
                ids.add(document["goal_id"])
            if answer.status_code in (200, 202):
                self.accepted[number] = document["goal_id"]
                assert ids == {document["goal_id"]}, "a retry got another goal"
            else:
                assert answer.status_code in (404, 409, 429, 503, 504), answer.text
                time.sleep(0.1)
        time.sleep(0.05)


class Reader(Worker):
    """Reads every event, and resumes after the last one wherever it can."""

    def __init__(self, url: Callable[[], str]) -> None:
        super().__init__("reader")
        self._url = url
        self.events: list[dict[str, Any]] = []
        self.notices: Counter[str] = Counter()
        self.older: list[tuple[str, str]] = []
        self.resumed: list[tuple[str, str]] = []

    def connect(self, url: str) -> ClientConnection:
        return connect(url, open_timeout=5)

    def turn(self) -> None:
        last = max((event["id"] for event in self.events), default="")
        url = f"{self._url().replace('http', 'ws')}/ws/feedback" + (f"?after={last}" if last else "")
        try:
            with self.connect(url) as connection:
                self.resumed.append((url.partition("/ws")[0], last))
                while not self.stopping.is_set():
                    try:
                        event = orjson.loads(connection.recv(0.5))
                    except TimeoutError:
                        continue
                    if "id" not in event or event["type"] in ("snapshot", "heartbeat"):  # their id is a position
                        self.notices[event["type"]] += 1
                        continue
                    if event["id"] <= last:
                        self.older.append((last, event["id"]))
                    self.events.append(event)
        except BROKEN:
            time.sleep(0.05)

    def ends(self, kind: str) -> Counter[str]:
        """How often each goal ended, by the events of a type."""
        return Counter(event["goal_id"] for event in self.events if ends(event, kind))


def ends(event: dict[str, Any], kind: str = "result") -> bool:
    """Whether an event tells of the end of a goal."""
    return event["type"] == kind and event["status"] in FINAL


class Load:
    """Senders and a reader, all at work within the block.

    Args:
        url: Where a gateway is now; called again for each try.
        senders: How many.
    """

    def __init__(self, url: Callable[[], str], senders: int = 3) -> None:
        self.senders = [Sender(url) for _ in range(senders)]
        self.reader = Reader(url)

    def __enter__(self) -> Self:
        for worker in (self.reader, *self.senders):
            worker.start()
        return self

    def __exit__(self, *_: object) -> None:
        for worker in (self.reader, *self.senders):
            worker.stopping.set()

    @property
    def accepted(self) -> dict[int, str]:
        """The id of each goal that was accepted, by its number."""
        return {number: goal_id for sender in self.senders for number, goal_id in sender.accepted.items()}

    @contextmanager
    def paused(self) -> Iterator[None]:
        """No sender begins another goal."""
        for sender in self.senders:
            sender.going.clear()
        try:
            yield
        finally:
            for sender in self.senders:
                sender.going.set()

    def stop_sending(self) -> None:
        for sender in self.senders:
            sender.finish()

    def wait_for_all_ends(self, timeout: float = 60.0) -> None:
        """Wait until the reader has been told the end of each goal that was accepted."""
        goals, deadline = set(self.accepted.values()), time.monotonic() + timeout
        while not goals <= self.reader.ends("result").keys() and time.monotonic() < deadline:
            time.sleep(0.1)
        self.reader.finish()
