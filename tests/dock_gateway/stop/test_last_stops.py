"""No stop is forgotten, whichever of two gateways hears of it, and whoever releases it."""

import asyncio
from datetime import UTC, datetime, timedelta

from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.stop.last_stops import LastStop, LastStops
from tests.support.entries import SharedStore

NOON = datetime(2026, 11, 30, 12, tzinfo=UTC)
DOINGS = ("stop", "release", "sync", "continue")


class TwoGateways:
    """They share a history, and read each other's stops when they are told to."""

    def __init__(self) -> None:
        store = SharedStore[LastStop]()
        self.gateways = LastStops(store), LastStops(store)
        self.allowed_at = NOON
        self.stopped_at: datetime | None = None
        """When the robot was last stopped since somebody said *continue*."""
        self.heard_at: datetime | None = None
        """When it was last stopped or released since then."""

    async def do(self, doing: str, gateway: LastStops, now: datetime) -> None:
        match doing:
            case "stop":
                gateway.note("/", now)
                self.stopped_at = self.heard_at = now
            case "release":
                gateway.note_release("/", now)
                self.heard_at = now
            case "sync":
                await gateway.sync()
            case "continue":
                await gateway.allow("/", now)
                self.allowed_at = now
                self.stopped_at = self.heard_at = None

    async def agree(self) -> None:
        for gateway in (*self.gateways, *self.gateways):
            await gateway.sync()


@given(doings=st.lists(st.tuples(st.sampled_from(DOINGS), st.integers(0, 1)), max_size=15))
def test_what_came_after_continue_is_known_to_both_gateways(doings: list[tuple[str, int]]) -> None:
    async def run() -> None:
        two = TwoGateways()
        for second, (doing, index) in enumerate(doings, 1):
            await two.do(doing, two.gateways[index], NOON + timedelta(seconds=second))
        await two.agree()
        for gateway in two.gateways:
            assert gateway.any_since("/", two.allowed_at) == (two.stopped_at is not None)
            assert two.heard_at in (None, gateway.at("/"))
            assert gateway.all_at().get("/") == gateway.at("/")

    asyncio.run(run())
