"""A request to an action server on its way, as fakes of ports hand it out."""

import asyncio
from typing import Any


class FakeCall:
    """Answered by whoever sets `response`."""

    def __init__(self) -> None:
        self.response: asyncio.Future[Any] = asyncio.get_running_loop().create_future()

    def forget(self) -> None:
        """Nobody waits for it any more."""
        self.response.cancel()
