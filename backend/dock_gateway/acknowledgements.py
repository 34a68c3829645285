"""Who has acknowledged which alert: known here at once, and soon in the history, where other gateways see it."""

import asyncio
from contextlib import suppress

from dock_gateway.errors import Unavailable
from dock_gateway.history import Acknowledgement, AcknowledgementStore


class Acknowledgements:
    """Acknowledgements by the id of the alert. While the history does not answer, they are in this process alone.

    Args:
        store: Where they are kept.
    """

    def __init__(self, store: AcknowledgementStore) -> None:
        self._store = store
        self._known: dict[str, Acknowledgement] = {}
        self._unsaved: dict[str, Acknowledgement | None] = {}
        self._changes = 0
        self._saving = asyncio.Lock()

    @property
    def unsaved(self) -> bool:
        """Whether there is something that is not kept yet."""
        return bool(self._unsaved)

    def get(self, alert_id: str) -> Acknowledgement | None:
        """That of an alert, where there is one."""
        return self._known.get(alert_id)

    def ids(self) -> set[str]:
        """The alerts that are acknowledged."""
        return set(self._known)

    def put(self, alert_id: str, acknowledgement: Acknowledgement | None) -> None:
        """Take up an acknowledgement, or that there is none; `sync` keeps it."""
        if acknowledgement is None:
            self._known.pop(alert_id, None)
        else:
            self._known[alert_id] = acknowledgement
        self._unsaved[alert_id] = acknowledgement
        self._changes += 1

    async def sync(self) -> bool:
        """Keep what is not kept yet, and learn what other gateways have kept; False where the history is away."""
        try:
            await self._save()
            changes = self._changes
            kept = await self._store.read()
        except Unavailable:
            return False
        if changes == self._changes:  # else what was read may be older
            self._known = kept
        return True

    async def save(self) -> None:
        """Keep what is not kept yet, where the history answers."""
        with suppress(Unavailable):
            await self._save()

    async def _save(self) -> None:
        async with self._saving:
            for alert_id, acknowledgement in list(self._unsaved.items()):
                await self._store.write(alert_id, acknowledgement)
                if self._unsaved[alert_id] is acknowledgement:
                    del self._unsaved[alert_id]
