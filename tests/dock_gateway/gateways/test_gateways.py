"""No two gateways claim the same robots, whatever their clocks say, whoever dies, and while the database is away."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import AsyncExitStack
from dataclasses import replace
from datetime import timedelta
from itertools import count
from types import SimpleNamespace

import pytest

from dock_gateway.core.errors import Conflict
from dock_gateway.core.event import utc_now
from dock_gateway.core.share import Claim, Share
from dock_gateway.gateways import gateways as claims
from dock_gateway.gateways.gateways import Gateways
from dock_gateway.gateways.machine import boot_id, host_name
from tests.support.entries import SharedStore
from tests.support.waiting import until

Make = Callable[..., Gateways]


@pytest.fixture
def store() -> SharedStore[Claim]:
    return SharedStore()


@pytest.fixture
async def make(store: SharedStore[Claim]) -> AsyncIterator[Make]:
    async with AsyncExitStack() as stack:

        def gateway(*robots: str, address: str = "", beat: float = 0.01, expiry: float = 60.0) -> Gateways:
            made = Gateways(store, Share(robots), address, shared=True, beat=beat, expiry=expiry)
            stack.push_async_callback(made.close)
            return made

        yield gateway


def left_behind(*robots: str) -> Claim:
    """The claim of a gateway that was killed, with a clock that is an hour ahead."""
    later = utc_now() + timedelta(hours=1)
    return Claim("dead", "boot", "http://dead:8000", robots, (), "1.0.0", later, later, 7)


async def test_two_that_share_no_robot_know_each_other(make: Make) -> None:
    first, second = make("/fleet_a/*"), make("/fleet_b/*")
    first.robots = lambda: ["/fleet_a/robot1"]
    await first.open()
    first.listen("http://host:8000")
    await second.open()
    await until(lambda: [claim.serves for claim in second.others()] == [("/fleet_a/robot1",)])
    await until(lambda: [claim.address for claim in second.others()] == ["http://host:8000"])
    own, other = second.document()["gateways"]
    assert (own["id"], own["this"], own["robots"]) == (second.id, True, ("/fleet_b/*",))
    assert (other["id"], other["this"], other["claimed"]) == (first.id, False, True)
    await first.close()
    await until(lambda: not second.others())


@pytest.mark.parametrize(("first", "second"), [(["/a/*"], ["/a/robot1"]), ([], ["/a/*"]), (["/a/*"], [])])
async def test_the_second_of_two_with_the_same_robots_is_refused(
    make: Make, first: list[str], second: list[str]
) -> None:
    await make(*first).open()
    with pytest.raises(Conflict, match="no two gateways may serve the same robots") as refused:
        await make(*second).open()
    assert refused.value.code == "robots_claimed"


async def test_of_two_that_start_at_once_one_is_refused(make: Make) -> None:
    outcomes = await asyncio.gather(*(make("/a/*").open() for _ in range(2)), return_exceptions=True)
    assert sorted(type(each).__name__ for each in outcomes) == ["Conflict", "NoneType"]


async def test_gateways_with_every_robot_are_replicas(make: Make) -> None:
    first, second = make(), make()
    await first.open()
    await second.open()
    await until(lambda: bool(first.others() and second.others()))
    assert (first.conflict, second.conflict) == (None, None)


async def test_the_claim_of_a_gateway_that_was_killed_ends_whatever_its_clock_said(
    make: Make, store: SharedStore[Claim]
) -> None:
    await store.write("dead", left_behind("/a/*"))
    gateway = make("/a/robot1", expiry=0.05)
    await gateway.open()
    assert {*await store.read()} == {gateway.id}


@pytest.mark.parametrize("step", [0.001 * thousandths for thousandths in range(5, 50, 3)])
async def test_whenever_that_claim_ends_it_is_removed_before_another_one_is_made(
    make: Make, store: SharedStore[Claim], monkeypatch: pytest.MonkeyPatch, step: float
) -> None:
    """The clock goes on at each look at it: nothing may be judged twice, as it could be over in between."""
    clock = count(0.0, step)
    monkeypatch.setattr(claims, "time", SimpleNamespace(monotonic=lambda: next(clock)))
    await store.write("dead", left_behind("/a/*"))
    gateway = make("/a/robot1", expiry=0.05)
    await gateway.open()
    assert {*await store.read()} == {gateway.id}


async def test_a_gateway_that_was_killed_is_replaced_at_once_on_its_own_port(
    make: Make, store: SharedStore[Claim]
) -> None:
    address = "http://127.0.0.1:8000"
    await store.write("dead", replace(left_behind("/a/*"), host=host_name(), boot=boot_id(), address=address))
    gateway = make("/a/*", address=address)
    await gateway.open()
    assert {*await store.read()} == {gateway.id}


async def test_a_start_without_the_database_claims_when_it_is_back(make: Make, store: SharedStore[Claim]) -> None:
    store.away = True
    gateway = make("/a/*")
    await gateway.open()
    assert gateway.others() == []
    store.away = False
    await until(lambda: gateway.document()["gateways"][0]["claimed"])
    assert {*await store.read()} == {gateway.id}


async def test_who_finds_its_robots_claimed_goes_on_says_so_and_claims_them_again(
    make: Make, store: SharedStore[Claim]
) -> None:
    store.away = True
    late = make("/a/*")
    await late.open()
    store.away = False
    first = make("/a/robot1")
    await first.open()
    await until(lambda: late.conflict is not None)
    await until(lambda: [claim.claimed for claim in first.others()] == [False])
    assert first.conflict is None
    await first.close()
    await until(lambda: late.conflict is None)
    assert (await store.read())[late.id].claimed


async def test_a_database_of_one_gateway_gets_no_claim(store: SharedStore[Claim]) -> None:
    gateway = Gateways(store, Share(["/a/*"]), shared=False)
    await gateway.open()
    await gateway.close()
    assert await store.read() == {}
    assert [each["robots"] for each in gateway.document()["gateways"]] == [("/a/*",)]
