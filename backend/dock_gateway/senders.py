"""Senders of goals that turned up by themselves: a gateway, whose history tells of them, or somebody else."""

import asyncio
import contextlib
from collections.abc import Callable

from dock_gateway.errors import GatewayError
from dock_gateway.goals import Goal
from dock_gateway.history import History

# What is said of a goal that is new to us waits so long for what the history knows of it.
LOOK_UP_WAIT = 0.5
# The gateway that sent it may just be storing it: the history is asked again after these pauses, and later once more.
LOOK_UP_PAUSES = (0.01, 0.03, 0.06)
LOOK_AGAIN_AFTER = 2.0


class Senders:
    """Looks up who sent a goal, and what was asked for.

    Args:
        history: Where goals are kept, also by other gateways.
    """

    def __init__(self, history: History) -> None:
        self._history = history

    async def find(self, goal: Goal, remember: Callable[[Goal, Goal], None]) -> None:
        """Have the goal take over what the history knows of it, which is asked again, for a moment, until it does.

        Args:
            goal: The goal.
            remember: Called with the goal and what was known of it at once.
        """
        with contextlib.suppress(TimeoutError, GatewayError):
            async with asyncio.timeout(LOOK_UP_WAIT):
                known = await self._history.get(goal.goal_id)
                if known is not None and goal.origin != "gateway":
                    remember(goal, known)
                for pause in LOOK_UP_PAUSES:
                    if goal.origin == "gateway":
                        break
                    await asyncio.sleep(pause)
                    await self._ask(goal)

    async def find_late(self, goal: Goal) -> bool:
        """Ask once more, later; whether a gateway sent the goal after all."""
        await asyncio.sleep(LOOK_AGAIN_AFTER)
        with contextlib.suppress(GatewayError):
            await self._ask(goal)
        return goal.origin == "gateway"

    async def _ask(self, goal: Goal) -> None:
        known = await self._history.get(goal.goal_id)
        if known is not None:
            goal.attribute(known)
