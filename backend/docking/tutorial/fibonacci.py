"""The Fibonacci sequence of the official action tutorial."""

from dataclasses import dataclass

from docking.core.parameter import NodeSettings, number

MAX_ORDER = 46
"""The largest order whose last number still fits in the message's int32."""


@dataclass(frozen=True)
class FibonacciSettings(NodeSettings):
    """The parameters of the action server."""

    step_period: float = number(1.0, 0.01, 60.0, "s", "Time between two numbers.")


def check_order(order: int) -> str | None:
    """Return why a sequence of this order cannot be computed; None where it can."""
    if 0 <= order <= MAX_ORDER:
        return None
    return f"order is {order}, but must be from 0 to {MAX_ORDER} (beyond that the numbers do not fit in an int32)"


class Fibonacci:
    """A sequence that grows by one number a step, from 0 1 to the number of the given order."""

    def __init__(self, order: int) -> None:
        self.sequence = [0, 1]
        self._order = order

    @property
    def complete(self) -> bool:
        """Whether the number of the given order is there."""
        return len(self.sequence) > self._order

    def step(self) -> None:
        """Add a number."""
        self.sequence.append(self.sequence[-1] + self.sequence[-2])
