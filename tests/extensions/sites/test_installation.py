"""The id of an installation, and the state of the connection to the hub."""

import pytest

from dock_gateway.extensions.sites.installation import read_installation
from dock_gateway.extensions.sites.link import HubLink
from tests.support.history import HistoryInMemory


async def test_an_installation_is_made_once() -> None:
    history = HistoryInMemory()
    first = await read_installation(history)
    assert await read_installation(history) == first
    assert await read_installation(HistoryInMemory()) != first


def test_each_reason_is_logged_once(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO")
    link = HubLink("berlin")
    for _ in range(2):
        link.lose("hub_silent", "the hub does not answer")
    since = link.changed_at
    link.lose("broker_unavailable", "there is no connection")
    assert link.changed_at == since
    for _ in range(2):
        link.refuse("site_name_taken", "the name berlin belongs to another gateway")
    assert link.document()["detail"] == "the name berlin belongs to another gateway"
    for _ in range(2):
        link.connected("0.2.0")
    assert link.document() == {
        "site": "berlin",
        "state": "connected",
        "changed_at": link.changed_at,
        "code": None,
        "detail": None,
    }
    assert [record.getMessage().partition(" the site berlin")[2] for record in caplog.records] == [
        ", which works on without it: the hub does not answer",
        ", which works on without it: there is no connection",
        ": the name berlin belongs to another gateway",
        "; the hub is dock-gateway 0.2.0",
    ]
