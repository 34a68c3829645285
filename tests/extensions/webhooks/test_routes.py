"""Webhooks over HTTP: what is stored, what is refused with which field or code, and that secrets are not shown."""

from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from types import SimpleNamespace
from typing import Any, cast

import pytest
from fastapi import FastAPI
from hypothesis import given, settings

from dock_gateway.extensions.webhooks.delivery import DeliveryEntry
from dock_gateway.extensions.webhooks.notifier import Notifier
from dock_gateway.extensions.webhooks.outbox import Outbox
from dock_gateway.extensions.webhooks.webhook import WebhookEntry
from dock_gateway.extensions.webhooks.webhooks import Webhooks
from dock_gateway.robots.labels import RobotLabel
from dock_gateway.storage.shared_entries import SharedBook, SharedEntries
from tests.support.history import HistoryInMemory
from tests.support.route_client import RouteClient
from tests.support.versions import STEPS, Resource, Step, require_that_nothing_is_lost
from tests.support.webhooks import Receiver

SECRET = "whsec_" + "A" * 32


class Client(RouteClient):
    """`/webhooks` of a gateway that has no alerts."""

    def __init__(self) -> None:
        super().__init__()
        self._history = HistoryInMemory()

    @asynccontextmanager
    async def opened(self, _: FastAPI) -> AsyncIterator[dict[str, Any]]:
        book = SharedBook(self._history.documents("webhook", WebhookEntry), "webhook", 2)
        outbox = Outbox(book, SharedEntries(self._history.documents("delivery", DeliveryEntry)))
        notifier = Notifier(
            cast("Any", SimpleNamespace(documents=list)),
            cast("Any", SimpleNamespace(get=lambda _: RobotLabel(None, ()))),
            book,
            outbox,
        )
        self.parts.add(Webhooks, Webhooks(book, outbox, notifier))
        yield {"parts": self.parts}
        await outbox.close()

    def put(self, body: object, status: int = 200, webhook_id: str = "hook") -> Any:
        return self.send("PUT", f"/webhooks/{webhook_id}", status, json=body, template="/webhooks/{webhook_id}")


@pytest.fixture
def client() -> Iterator[Client]:
    with Client() as client:
        yield client


HOOK = {"name": "Control room", "url": "https://hooks.example.com/a?b=c"}


def test_webhooks_are_stored_listed_tested_and_removed(client: Client, receiver: Receiver) -> None:
    assert client.send("GET", "/webhooks") == {"webhooks": []}
    stored = client.put(HOOK | {"url": receiver.url, "by": " Ada "}, 201)
    assert stored["secret"].startswith("whsec_")
    assert (stored["enabled"], stored["severities"], stored["changed_by"]) == (True, ["critical", "warning"], "Ada")
    assert stored["robots"] == {"all": True, "names": [], "groups": []}
    (listed,) = client.send("GET", "/webhooks")["webhooks"]
    assert listed == {name: value for name, value in stored.items() if name != "secret"}
    tested = client.send("POST", "/webhooks/hook/test", template="/webhooks/{webhook_id}/test")
    assert (tested["state"], tested["status_code"], receiver.seen()) == ("delivered", 204, [("test", "")])
    path = "/webhooks/{webhook_id}/deliveries"
    assert client.send("GET", "/webhooks/hook/deliveries?limit=5", template=path)["deliveries"] == [tested]
    assert client.send("GET", "/webhooks")["webhooks"][0]["last_delivery"] == tested
    for _ in range(2):
        client.send("DELETE", "/webhooks/hook", 204, template="/webhooks/{webhook_id}")
    for method, suffix in (("GET", ""), ("POST", "/test"), ("GET", "/deliveries")):
        missing = client.send(method, f"/webhooks/hook{suffix}", 404, template=f"/webhooks/{{webhook_id}}{suffix}")
        assert missing["code"] == "webhook_not_found"


def test_a_secret_may_be_given(client: Client) -> None:
    given = HOOK | {"secret": SECRET, "enabled": False, "severities": ["warning"]}
    assert client.put(given, 201)["secret"] is None
    assert client.put(HOOK | {"secret": None})["secret"] is None
    assert SECRET not in str(client.send("GET", "/webhooks"))


def test_there_is_a_limit(client: Client) -> None:
    for webhook_id in ("a", "b"):
        client.put(HOOK, 201, webhook_id)
    assert client.put(HOOK, 409, "c")["code"] == "limit_reached"
    client.put(HOOK | {"name": "Other"}, webhook_id="b")


@pytest.mark.parametrize(
    ("webhook", "path"),
    [
        ([], ""),
        (HOOK | {"url": ""}, "url"),
        (HOOK | {"url": "hooks.example.com"}, "url"),
        (HOOK | {"url": "ftp://hooks.example.com"}, "url"),
        (HOOK | {"url": "file:///etc/passwd"}, "url"),
        (HOOK | {"url": "http:///path"}, "url"),
        (HOOK | {"url": "http://a b/"}, "url"),
        (HOOK | {"url": "http://[::1"}, "url"),
        (HOOK | {"url": "http://a:99999/"}, "url"),
        (HOOK | {"url": "http://a/\n"}, "url"),
        (HOOK | {"url": "http://ada:secret@a/"}, "url"),
        (HOOK | {"url": "http://ada@a/"}, "url"),
        (HOOK | {"url": "http://:secret@a/"}, "url"),
        (HOOK | {"url": "http://a/\r\nX-Admin: 1"}, "url"),
        (HOOK | {"url": "http://a\r\n/"}, "url"),
        (HOOK | {"url": "gopher://a/"}, "url"),
        (HOOK | {"url": "unix:///var/run/docker.sock"}, "url"),
        (HOOK | {"url": "//a/"}, "url"),
        (HOOK | {"url": "http+unix://a/"}, "url"),
        (HOOK | {"secret": "short"}, "secret"),
        (HOOK | {"robots": {}}, "robots"),
    ],
)
def test_what_is_no_webhook(client: Client, webhook: object, path: str) -> None:
    """Beyond what its schema says: see test_bodies.py."""
    problem = client.put(webhook, 422)
    assert [error["path"] for error in problem["errors"]] == [path]
    assert client.send("GET", "/webhooks") == {"webhooks": []}


def test_what_is_no_id(client: Client) -> None:
    assert client.put(HOOK, 422, "Hook")["errors"][0]["path"] == "webhook_id"


@settings(max_examples=30, deadline=None)
@given(STEPS)
def test_of_two_people_who_change_a_webhook_none_loses_a_change(steps: list[tuple[Step, int]]) -> None:
    with Client() as client:
        number = lambda webhook: int(webhook["name"])  # noqa: E731
        webhook = Resource(client.http, "/webhooks/hook", lambda each: HOOK | {"name": str(each)}, number)
        require_that_nothing_is_lost(webhook, steps)
