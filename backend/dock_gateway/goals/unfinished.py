"""Goals that have not ended: taken over from the history at the start, and stored again if it loses its data."""

import asyncio
import logging
from datetime import datetime

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.event import utc_now
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.storage import History

log = logging.getLogger(__name__)

# Seconds before a history that does not answer is read again.
RETRY_INTERVAL = 1.0


async def take_over_unfinished(actions: ActionRegistry, history: History) -> None:
    """Take over goals that were running when the gateway ended; those in an unavailable database once it is back."""
    began = utc_now()
    try:
        if not await _expect(actions, history, began, complete=True):
            await _expect(actions, history, began)
            while not await _expect(actions, history, began, complete=True):  # noqa: ASYNC110 - there is no event for it
                await asyncio.sleep(RETRY_INTERVAL)
    except Exception:
        log.exception("while restoring earlier goals")


async def _expect(actions: ActionRegistry, history: History, began: datetime, *, complete: bool = False) -> bool:
    """Expect earlier goals that have not ended; return False if the history does not answer."""
    try:
        unfinished = await history.unfinished(complete=complete)
    except Unavailable:
        return False
    actions.expect([goal for goal in unfinished if goal.created_at < began])
    return True


def store_unfinished(actions: ActionRegistry, history: History) -> None:
    """Store the unfinished goals again, after the history has lost its data."""
    for goal in (*actions.running(), *actions.lost()):
        history.record(goal)
