"""A bridge without ROS."""

import asyncio
from collections.abc import Callable
from typing import Any


class FakeBridge:
    """Runs at once what belongs on the ROS thread."""

    async def call(self, function: Callable[[], Any], **_: object) -> Any:
        await asyncio.sleep(0)
        return function()

    def to_ros(self, function: Callable[[], Any]) -> None:
        function()
