"""The notifier with a real receiver: each alert once, whatever the gateways, the history and the receiver do."""

import asyncio
from collections.abc import AsyncIterator
from datetime import UTC, datetime, timedelta
from types import SimpleNamespace
from typing import Any, cast

import pytest

from dock_gateway.core.errors import Conflict, NotFound
from dock_gateway.core.fanout import Fanout
from dock_gateway.extensions.webhooks.delivery import DeliveryEntry, DeliveryState
from dock_gateway.extensions.webhooks.notifier import Notifier
from dock_gateway.extensions.webhooks.outbox import Outbox
from dock_gateway.extensions.webhooks.sender import sign
from dock_gateway.extensions.webhooks.webhook import WebhookEntry
from dock_gateway.extensions.webhooks.webhooks import Webhooks
from dock_gateway.fleet.alert_board import AlertBoard
from dock_gateway.http.schema import RobotSelection
from dock_gateway.robots.labels import Labels, RobotLabel
from dock_gateway.storage.shared_entries import SharedBook, SharedEntries
from tests.support.entries import SharedStore
from tests.support.robot_states import robot
from tests.support.waiting import until
from tests.support.webhooks import Receiver

HALL = RobotSelection(groups=("hall 1",))
NOON = datetime(2026, 1, 1, 12, tzinfo=UTC)
LABELS = {"/robot1": RobotLabel("Left forklift", ("hall 1",))}
RAISED, CLEARED = "alert.raised", "alert.cleared"


def alert(kind: str, robot: str | None = "/robot1", severity: str = "critical") -> dict[str, Any]:
    return {
        "id": f"{kind}-{robot}",
        "kind": kind,
        "robot": robot,
        "severity": severity,
        "started_at": NOON,
        "title": kind.title(),
        "detail": "What to do.",
        "goal_id": None,
        "acknowledged": None,
    }


STOP, LOW, LOST = alert("stop"), alert("low", severity="warning"), alert("lost", None, "warning")


class Gateway(Webhooks):
    """The webhooks of one gateway."""

    def __init__(self, alerts: Any, book: SharedBook[WebhookEntry], outbox: Outbox, **timing: Any) -> None:
        labels = cast("Labels", SimpleNamespace(get=lambda robot: LABELS.get(robot, RobotLabel(None, ()))))
        self.notifier = Notifier(
            alerts, labels, book, outbox, **{"interval": 0.01, "read_every": 1, "tidy_every": 1} | timing
        )
        self.outbox = outbox
        super().__init__(book, outbox, self.notifier)
        self.notifier.start()

    async def close(self) -> None:
        await self.notifier.close()
        await self.outbox.close()


class Site:
    """Gateways with one history, and the alerts that each of them sees."""

    def __init__(self, url: str) -> None:
        self.url = url
        self.webhooks = SharedStore[WebhookEntry]()
        self.deliveries = SharedStore[DeliveryEntry]()
        self.gateways: list[Gateway] = []
        self.alerts: list[list[dict[str, Any]]] = []

    def gateway(
        self,
        *alerts: dict[str, Any],
        board: AlertBoard | None = None,
        retry_after: tuple[float, ...] = (0.05, 0.05),
        overdue: float = 30.0,
        **timing: Any,
    ) -> Gateway:
        seen = list(alerts)
        book, deliveries = SharedBook(self.webhooks, "webhook", 2), SharedEntries(self.deliveries)
        outbox = Outbox(book, deliveries, retry_after=retry_after, overdue=timedelta(seconds=overdue))
        gateway = Gateway(board or SimpleNamespace(documents=lambda: list(seen)), book, outbox, **timing)
        if board is not None:
            board.on_change.append(gateway.notifier.compare)
        self.gateways.append(gateway)
        self.alerts.append(seen)
        return gateway

    def hook(self, **fields: Any) -> WebhookEntry:
        values = {"name": "Hook", "url": self.url, "secret": "", "changed_by": None, "changed_at": NOON}
        return WebhookEntry(**(values | fields))

    async def states(self) -> list[DeliveryState]:
        stored = await self.deliveries.read()
        return [each.state for each in sorted(stored.values(), key=lambda each: each.created_at)]

    async def close(self) -> None:
        for gateway in self.gateways:
            await gateway.close()


@pytest.fixture
async def site(receiver: Receiver) -> AsyncIterator[Site]:
    site = Site(receiver.url)
    yield site
    await site.close()


async def looks(count: int = 10) -> None:
    await asyncio.sleep(0.01 * count)


async def test_the_beginning_and_the_end_of_each_alert_are_sent_and_signed(site: Site, receiver: Receiver) -> None:
    gateway = site.gateway(STOP)
    stored, _ = await gateway.replace("hook", site.hook())
    await until(lambda: receiver.seen() == [(RAISED, "stop")])
    site.alerts[0].append(LOST)
    await until(lambda: len(receiver.bodies) == 2)
    site.alerts[0].clear()
    await until(lambda: len(receiver.bodies) == 4)
    assert receiver.seen()[1] == (RAISED, "lost")
    assert sorted(receiver.seen()[2:]) == [(CLEARED, "lost"), (CLEARED, "stop")]
    first, lost, *_ = receiver.events()
    assert first["data"] == STOP | {
        "started_at": "2026-01-01T12:00:00Z",
        "display_name": "Left forklift",
        "groups": ["hall 1"],
    }
    assert first["text"] == "Stop (Left forklift): What to do."
    assert (lost["text"], lost["data"]["groups"]) == ("Lost (the gateway): What to do.", [])
    for headers, body in zip(receiver.headers, receiver.bodies, strict=True):
        at = datetime.fromtimestamp(int(headers["webhook-timestamp"]), UTC)
        assert dict(sign(stored["secret"], headers["webhook-id"], at, body)).items() <= headers.items()
    assert len({headers["webhook-id"] for headers in receiver.headers}) == 4
    site.alerts[0].append(STOP)  # it comes again
    await until(lambda: len(receiver.bodies) == 5)


async def test_an_alert_that_lasts_for_a_moment_is_sent(site: Site, receiver: Receiver) -> None:
    board = AlertBoard(Fanout(queue_limit=1), SharedEntries(SharedStore()), low_battery=0.2)
    gateway = site.gateway(board=board)
    await gateway.replace("hook", site.hook())
    board.update([robot(percentage=0.1)], [])
    board.update([robot(percentage=0.9)], [])
    await until(lambda: receiver.seen() == [(RAISED, "low_battery"), (CLEARED, "low_battery")])
    await board.close()


async def test_a_webhook_gets_what_it_wants(site: Site, receiver: Receiver) -> None:
    gateway = site.gateway(STOP, LOW, alert("stop", "/robot2"))
    await gateway.replace("hook", site.hook(severities=["critical"], robots=HALL))
    await until(lambda: len(receiver.bodies) == 1)
    await gateway.replace("hook", site.hook(robots=HALL))  # as of now warnings, too
    await until(lambda: len(receiver.bodies) == 2)
    await gateway.replace("hook", site.hook(enabled=False))
    site.alerts[0].clear()
    await looks()
    assert receiver.seen() == [(RAISED, "stop"), (RAISED, "low")]
    site.alerts[0].append(STOP)
    await gateway.replace("hook", site.hook())  # on again: told of what there is
    await until(lambda: len(receiver.bodies) == 3)


async def test_it_is_sent_again_until_it_is_taken_and_given_up_at_last(site: Site, receiver: Receiver) -> None:
    receiver.answers += [500, 503]
    gateway = site.gateway(STOP)
    await gateway.replace("hook", site.hook())
    await until(lambda: len(receiver.bodies) == 3)
    assert len({headers["webhook-id"] for headers in receiver.headers}) == 1
    (document,) = await gateway.documents()
    await until(lambda: not receiver.answers)
    while (document := (await gateway.documents())[0])["pending"]:
        await looks(1)
    assert (document["last_delivery"]["state"], document["last_delivery"]["attempts"]) == ("delivered", 3)
    assert gateway.attempts == {DeliveryState.PENDING: 2, DeliveryState.DELIVERED: 1}
    receiver.answers += [500, 500, 500]
    site.alerts[0].append(LOW)
    await until(lambda: not receiver.answers)
    while (document := (await gateway.documents())[0])["pending"]:
        await looks(1)
    last = document["last_delivery"]
    assert (last["state"], last["status_code"], last["error"]) == ("failed", 500, "the answer was 500")


async def test_several_gateways_send_an_alert_once(site: Site, receiver: Receiver) -> None:
    first, second = site.gateway(STOP), site.gateway(STOP)
    await first.replace("hook", site.hook())
    await until(lambda: len(receiver.bodies) >= 1)
    site.alerts[0].clear()
    await until(lambda: len(receiver.bodies) >= 2)
    await looks()
    site.alerts[1].clear()  # the second notices later
    await looks()
    assert receiver.seen() == [(RAISED, "stop"), (CLEARED, "stop")]
    ids = [[each["id"] for each in (await gateway.deliveries("hook", 10))[0]] for gateway in (first, second)]
    assert ids[0] == ids[1]


async def test_a_gateway_that_does_not_see_an_alert_does_not_end_it(site: Site, receiver: Receiver) -> None:
    first, _ = site.gateway(STOP), site.gateway()
    await first.replace("hook", site.hook())
    await until(lambda: len(receiver.bodies) == 1)
    await looks(20)
    assert receiver.seen() == [(RAISED, "stop")]


async def test_after_a_restart_an_alert_is_neither_repeated_nor_forgotten(site: Site, receiver: Receiver) -> None:
    gateway = site.gateway(STOP, LOW)
    await gateway.replace("hook", site.hook())
    await until(lambda: len(receiver.bodies) == 2)
    receiver.release.clear()
    site.alerts[0].append(LOST)
    await until(lambda: len(receiver.bodies) == 3)  # it is not answered before the gateway ends
    await gateway.close()
    receiver.release.set()
    site.gateway(STOP, settled_after=0.2, overdue=0.0)  # the others ended meanwhile
    await until(lambda: len(receiver.bodies) == 6)
    assert receiver.seen()[2] == receiver.seen()[3] == (RAISED, "lost")
    assert receiver.headers[2]["webhook-id"] == receiver.headers[3]["webhook-id"]
    assert sorted(receiver.seen()[4:]) == [(CLEARED, "lost"), (CLEARED, "low")]


async def test_what_a_gateway_left_is_taken_over_by_another(site: Site, receiver: Receiver) -> None:
    receiver.answers.append(500)
    gateway = site.gateway(STOP, retry_after=(0.3, 0.3))
    await gateway.replace("hook", site.hook())
    while (await gateway.documents())[0]["last_delivery"] is None:
        await looks(1)
    await gateway.close()
    site.gateway(STOP, overdue=0.3)
    await until(lambda: len(receiver.bodies) == 2)
    assert receiver.bodies[0] == receiver.bodies[1]


async def test_what_another_gateway_has_sent_is_not_taken_over(site: Site, receiver: Receiver) -> None:
    """A gateway that looked while the other one was sending does not take that for its end."""
    receiver.release.clear()
    first, second = [site.gateway(STOP, tidy_every=1_000_000, overdue=0.5) for _ in range(2)]
    await first.replace("hook", site.hook())
    await until(lambda: len(receiver.bodies) == 1)
    assert [each["state"] for each in (await second.deliveries("hook", 10))[0]] == ["pending"]
    receiver.release.set()
    while await site.states() != [DeliveryState.DELIVERED]:
        await looks(1)
    await asyncio.sleep(0.7)
    assert len(receiver.bodies) == 1


async def test_alerts_are_sent_without_the_history_too(site: Site, receiver: Receiver) -> None:
    gateway = site.gateway()
    await gateway.replace("hook", site.hook())
    site.webhooks.away = site.deliveries.away = True
    site.alerts[0].append(LOST)
    await until(lambda: len(receiver.bodies) == 1)
    site.webhooks.away = site.deliveries.away = False
    while await site.states() != [DeliveryState.DELIVERED]:
        await looks(1)
    assert len(receiver.bodies) == 1


async def test_an_event_does_not_wait_until_the_next_one_is_stored(
    site: Site, receiver: Receiver, monkeypatch: pytest.MonkeyPatch
) -> None:
    gateway = site.gateway()
    await gateway.replace("hook", site.hook())
    store, answers = site.deliveries.write, asyncio.Event()

    async def write(key: str, entry: DeliveryEntry | None, *more: Any) -> None:
        if entry is not None and entry.alert_id == LOW["id"]:
            await answers.wait()
        await store(key, entry, *more)

    monkeypatch.setattr(site.deliveries, "write", write)
    site.alerts[0] += [STOP, LOW]
    await until(lambda: receiver.seen() == [(RAISED, "stop")])
    answers.set()
    await until(lambda: receiver.seen() == [(RAISED, "stop"), (RAISED, "low")])


async def test_a_webhook_is_tested_once_at_a_time(site: Site, receiver: Receiver) -> None:
    gateway = site.gateway()
    await gateway.replace("hook", site.hook(enabled=False))
    receiver.answers.append(500)
    failed = await gateway.test("hook")
    assert (failed["type"], failed["state"], failed["status_code"], failed["attempts"]) == ("test", "failed", 500, 1)
    receiver.release.clear()
    testing = asyncio.create_task(gateway.test("hook"))
    await until(lambda: len(receiver.bodies) == 2)
    with pytest.raises(Conflict) as error:
        await gateway.test("hook")
    assert error.value.code == "test_running"
    receiver.release.set()
    delivered = await testing
    assert (delivered["state"], delivered["status_code"]) == ("delivered", 204)
    assert [each["id"] for each in (await gateway.deliveries("hook", 10))[0]] == [delivered["id"], failed["id"]]
    assert receiver.events()[1]["text"] == "This is a test of the webhook 'Hook'."


async def test_a_removed_webhook_gets_nothing_more(site: Site, receiver: Receiver) -> None:
    receiver.answers += [500] * 5
    gateway = site.gateway(STOP)
    await gateway.replace("hook", site.hook())
    await until(lambda: len(receiver.bodies) == 1)
    await gateway.remove("hook")
    sent = len(receiver.bodies)
    await looks(20)
    assert len(receiver.bodies) <= sent + 1  # one may have been on its way
    assert await site.deliveries.read() == {}
    for what in (gateway.remove("hook"), gateway.test("hook"), gateway.deliveries("hook", 1)):
        with pytest.raises(NotFound) as error:
            await cast("Any", what)
        assert error.value.code == "webhook_not_found"


async def test_the_secret_is_shown_once_and_kept(site: Site) -> None:
    gateway = site.gateway()
    made = (await gateway.replace("hook", site.hook()))[0]["secret"]
    assert made.startswith("whsec_")
    assert (await gateway.replace("hook", site.hook(name="Other")))[0]["secret"] is None
    assert (await site.webhooks.read())["hook"].secret == made
    given = "whsec_" + "A" * 32
    assert (await gateway.replace("hook", site.hook(secret=given)))[0]["secret"] is None
    assert (await site.webhooks.read())["hook"].secret == given
    assert "secret" not in (await gateway.documents())[0]
