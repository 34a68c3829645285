"""What somebody has to act on at shared docks, as alerts."""

from collections.abc import Iterator
from datetime import timedelta

from dock_gateway.core.event import utc_now
from dock_gateway.extensions.chargers import policy
from dock_gateway.extensions.chargers.shared_docks import SharedDocks
from dock_gateway.extensions.chargers.watch import Trouble
from dock_gateway.fleet.alert import Alert
from dock_gateway.fleet.alert_kinds import AlertKind

OUT_OF_ORDER = AlertKind("dock_out_of_order", critical=False)
NO_CONTACT = AlertKind("no_contact_at_dock")
CONTESTED = AlertKind("dock_contested")
LATE = AlertKind("dock_not_reached", critical=False)
KINDS = (OUT_OF_ORDER, NO_CONTACT, CONTESTED, LATE)
# How long a robot at a dock is not heard before that is an alert.
SILENT_FOR = timedelta(seconds=30)
# How long a robot may be on its way to a dock for which others wait.
LATE_AFTER = timedelta(minutes=15)


def dock_alerts(docks: SharedDocks, trouble: Trouble) -> Iterator[Alert]:
    """Return what somebody has to act on.

    Args:
        docks: The docks.
        trouble: What is wrong at them.
    """
    yield from _out_of_order(docks)
    yield from _silent(docks, trouble)
    for name, (robot, since) in sorted(trouble.contested.items()):
        detail = f"{robot} is at the dock {name} or drives there, and another robot has it. Stop one of them."
        yield Alert(CONTESTED, robot, since, f"Two robots at dock {name}", detail)
    yield from _late(docks)


def _out_of_order(docks: SharedDocks) -> Iterator[Alert]:
    records = docks.records.all()
    broken = {name: each for name in docks.book.all() if (each := records.get(name)) and each.out_of_order_at}
    if not broken:
        return
    since = min(each.out_of_order_at for each in broken.values() if each.out_of_order_at is not None)
    notes = "; ".join(f"{name}: {each.note or 'no reason given'}" for name, each in sorted(broken.items()))
    detail = f"No robot is sent there. {notes}. Mend it, then say on the page Docks that it is in order."
    yield Alert(OUT_OF_ORDER, None, since, f"Out of order: {', '.join(sorted(broken))}", detail)


def _silent(docks: SharedDocks, trouble: Trouble) -> Iterator[Alert]:
    records, now = docks.records.all(), utc_now()
    for name, since in sorted(trouble.silent.items()):
        hold = records[name].hold if name in records else None
        if hold is not None and hold.robot is not None and now - since >= SILENT_FOR:
            detail = (
                f"{hold.robot} has the dock {name}, and has not been heard since. Look where it is; if the dock is "
                "free, say so on the page Docks."
            )
            yield Alert(NO_CONTACT, hold.robot, since, f"No contact at dock {name}", detail)


def _late(docks: SharedDocks) -> Iterator[Alert]:
    """Return an alert for each robot that keeps others from a dock and does not arrive there."""
    known, waits, now = docks.book.all(), docks.waits.all(), utc_now()
    for name, record in sorted(docks.records.all().items()):
        hold = record.hold
        if name not in known or hold is None or hold.robot is None or hold.standing:
            continue
        asked = hold.asked_at or hold.since_at
        others = sum(
            robot != hold.robot and name in wait.docks and policy.is_waiting(wait, now) for robot, wait in waits.items()
        )
        if others and now - asked >= LATE_AFTER:
            who = "another robot waits" if others == 1 else f"{others} other robots wait"
            detail = (
                f"It has been on its way for more than 15 minutes, and {who}. Look what keeps it, or cancel its goal."
            )
            yield Alert(LATE, hold.robot, asked, f"{hold.robot} does not arrive at dock {name}", detail)
