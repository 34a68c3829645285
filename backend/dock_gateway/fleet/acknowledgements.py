"""Acknowledges an alert, or withdraws that."""

from collections.abc import Mapping

from dock_gateway.core.versions import UNCONDITIONAL, Condition
from dock_gateway.fleet.alert import Acknowledgement, Alert
from dock_gateway.storage.shared_entries import SharedEntries


async def acknowledge(
    acknowledgements: SharedEntries[Acknowledgement],
    alert: Alert,
    acknowledgement: Acknowledgement | None,
    condition: Condition,
) -> None:
    """Store the acknowledgement of an alert; None withdraws it.

    Raises:
        ChangedMeanwhile: The alert has not the version of the condition.
        Unavailable: There is a condition, and the history does not answer (`history_unavailable`).
    """
    if condition == UNCONDITIONAL:
        acknowledgements.put(alert.id, acknowledgement)
        await acknowledgements.save()
        return

    def check(stored: Mapping[str, Acknowledgement]) -> None:
        condition.require(alert.etag(stored.get(alert.id)))

    await acknowledgements.read()  # stores what is pending
    await acknowledgements.store(alert.id, acknowledgement, check)
