"""The id of this installation: one document in the history, made once, by which a hub knows a site again."""

import contextlib
import uuid
from collections.abc import Mapping
from dataclasses import dataclass

from dock_gateway.core.errors import Conflict
from dock_gateway.storage import History

KEY = "site"


@dataclass(frozen=True)
class Installation:
    """The installation, as it is stored."""

    installation: uuid.UUID


async def read_installation(history: History) -> uuid.UUID:
    """Return the id; make it if there is none. Gateways that share a history have the same one.

    Raises:
        Unavailable: The history does not answer (`history_unavailable`).
    """
    entries = history.documents("installation", Installation)

    def check(stored: Mapping[str, Installation]) -> None:
        if KEY in stored:
            raise Conflict("another gateway has made it meanwhile")

    stored = await entries.read()
    if KEY not in stored:
        with contextlib.suppress(Conflict):
            await entries.write(KEY, Installation(uuid.uuid4()), check)
        stored = await entries.read()
    return stored[KEY].installation
