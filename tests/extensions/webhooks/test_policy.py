"""When a delivery is sent, when again, and what is kept."""

from datetime import UTC, datetime, timedelta
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.extensions.webhooks import policy
from dock_gateway.extensions.webhooks.delivery import DeliveryEntry, DeliveryState, EventType
from dock_gateway.extensions.webhooks.policy import (
    RETRY_AFTER,
    ReceiverAnswer,
    after_attempt,
    due,
    find_open,
    open_alerts,
    surplus,
)
from dock_gateway.extensions.webhooks.webhook import WebhookEntry
from dock_gateway.http.schema import RobotSelection

NOON = datetime(2026, 1, 1, 12, tzinfo=UTC)
OK, REFUSED, AWAY = (
    ReceiverAnswer(204, None),
    ReceiverAnswer(500, "the answer was 500"),
    ReceiverAnswer(None, "no connection"),
)
NEW = DeliveryEntry(
    webhook_id="hook",
    type=EventType.RAISED,
    state=DeliveryState.PENDING,
    alert_id="a",
    created_at=NOON,
    event={},
    attempts=0,
    next_at=NOON,
    tried_at=None,
    status_code=None,
    error=None,
)
CHOSEN = RobotSelection(names=("/robot1",), groups=("hall 1",))
HOOK = WebhookEntry(
    name="Hook", url="http://x", severities=["critical"], robots=CHOSEN, secret="", changed_by=None, changed_at=NOON
)


def at(seconds: float, event_type: EventType = EventType.RAISED, **fields: Any) -> DeliveryEntry:
    moment = NOON + timedelta(seconds=seconds)
    return NEW.model_copy(update={"created_at": moment, "next_at": moment, "type": event_type} | fields)


def test_a_failed_attempt_is_repeated_ever_later_and_then_given_up() -> None:
    delivery, now = NEW, NOON
    for seconds in RETRY_AFTER:
        delivery = after_attempt(delivery, REFUSED, now)
        assert (delivery.state, delivery.status_code, delivery.tried_at) == (DeliveryState.PENDING, 500, now)
        assert delivery.next_at == now + timedelta(seconds=seconds)
        now = delivery.next_at
    delivery = after_attempt(delivery, AWAY, now)
    assert (delivery.state, delivery.attempts, delivery.next_at) == (DeliveryState.FAILED, len(RETRY_AFTER) + 1, None)
    assert (delivery.status_code, delivery.error) == (None, "no connection")


def test_success_410_and_a_test_end_a_delivery() -> None:
    delivered = after_attempt(after_attempt(NEW, REFUSED, NOON), OK, NOON)
    assert (delivered.state, delivered.attempts, delivered.error) == (DeliveryState.DELIVERED, 2, None)
    gone = after_attempt(NEW, ReceiverAnswer(410, "the answer was 410"), NOON)
    tested = after_attempt(at(0, EventType.TEST, alert_id=None), AWAY, NOON)
    assert [each.state for each in (gone, tested)] == [DeliveryState.FAILED] * 2


def test_the_end_of_an_alert_waits_for_its_beginning() -> None:
    later = NOON + timedelta(seconds=60)
    stored = {
        "cleared": at(1, EventType.CLEARED),
        "raised": at(0, next_at=later),
        "other alert": at(2, alert_id="b"),
        "other hook": at(3, webhook_id="second"),
        "sent": at(0, state=DeliveryState.DELIVERED, alert_id="c"),
    }
    assert [identity for identity, _ in due(stored, NOON + timedelta(seconds=10))] == ["other alert", "other hook"]
    assert next(due(stored, later))[0] == "raised"
    stored["raised"] = after_attempt(stored["raised"], OK, later)
    assert next(due(stored, later))[0] == "cleared"


@pytest.mark.parametrize(
    ("severity", "robot", "groups", "wanted"),
    [
        ("critical", "/robot1", (), True),
        ("critical", "/robot2", ("hall 1",), True),
        ("critical", "/robot2", ("hall 2",), False),
        ("critical", None, (), True),
        ("warning", "/robot1", (), False),
    ],
)
def test_which_alerts_a_webhook_wants(severity: str, robot: str | None, groups: tuple[str, ...], wanted: bool) -> None:
    assert HOOK.wants(severity, robot, groups) is wanted
    assert not HOOK.model_copy(update={"enabled": False}).wants(severity, robot, groups)
    assert HOOK.model_copy(update={"robots": RobotSelection(all=True)}).wants(severity, robot, groups) is (
        severity == "critical"
    )


Happening = tuple[EventType, str, str, DeliveryState]
happenings: st.SearchStrategy[list[Happening]] = st.lists(
    st.tuples(
        st.sampled_from([EventType.RAISED, EventType.CLEARED]),
        st.sampled_from(["first", "second"]),
        st.sampled_from("ab"),
        st.sampled_from(list(DeliveryState)),
    ),
    max_size=12,
)


@given(happenings)
def test_an_alert_is_open_until_its_end_whatever_is_removed_as_surplus(happened: list[Happening]) -> None:
    stored = {
        str(index): at(index, event_type, webhook_id=hook, alert_id=alert, state=state)
        for index, (event_type, hook, alert, state) in enumerate(happened)
    }
    last = {(hook, alert): event_type for event_type, hook, alert, _ in happened}
    expected = {about for about, event_type in last.items() if event_type is EventType.RAISED}

    def opened(deliveries: dict[str, DeliveryEntry]) -> set[tuple[str, str | None]]:
        return {(each.webhook_id, each.alert_id) for each in open_alerts(deliveries).values()}

    assert opened(stored) == expected
    for hook, alert in last:
        assert (find_open(stored, hook, alert) is not None) is ((hook, alert) in expected)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(policy, "MAX_KEPT", 1)
        removed = surplus(stored)
    kept = {identity: each for identity, each in stored.items() if identity not in removed}
    assert opened(kept) == expected
    pending = {identity for identity, each in stored.items() if each.state is DeliveryState.PENDING}
    assert pending <= kept.keys()
    busy = expected | {(stored[identity].webhook_id, stored[identity].alert_id) for identity in pending}
    assert len([each for each in kept.values() if (each.webhook_id, each.alert_id) not in busy]) <= 1


def test_an_alert_that_comes_and_goes_is_not_kept_for_ever() -> None:
    flapping = [EventType.RAISED, EventType.CLEARED] * (policy.MAX_KEPT // 2 + 10) + [EventType.RAISED]
    stored = {
        str(index): at(index, event_type, state=DeliveryState.DELIVERED) for index, event_type in enumerate(flapping)
    }
    assert surplus(stored) == [str(index) for index in range(20)]
