"""Display names and groups: whose a name is, what other gateways see, and what an outage leaves as it is."""

from collections.abc import AsyncIterator
from typing import Any

import pytest

from dock_gateway.core.errors import Conflict, Unavailable
from dock_gateway.robots.labels import NO_LABEL, Labels, RobotLabel
from tests.support.entries import SharedStore
from tests.support.waiting import until

LEFT = RobotLabel("Left forklift", ("hall 1",))


class Site:
    """Gateways that share a history."""

    def __init__(self) -> None:
        self.store = SharedStore[RobotLabel]()
        self.robots = ["/", "/robot1", "/robot2"]
        self.gateways: list[Labels] = []

    async def gateway(self, **limits: Any) -> Labels:
        labels = Labels(self.store, lambda: self.robots, **{"sync_interval": 0.01} | limits)
        self.gateways.append(labels)
        await labels.open()
        return labels


@pytest.fixture
async def site() -> AsyncIterator[Site]:
    site = Site()
    yield site
    for gateway in site.gateways:
        await gateway.close()


async def test_other_gateways_see_a_label_now_and_after_a_start(site: Site) -> None:
    one, other = await site.gateway(), await site.gateway()
    assert one.get("/robot1") == NO_LABEL
    await one.replace("/robot1", LEFT)
    assert one.get("/robot1") == LEFT
    await until(lambda: other.get("/robot1") == LEFT)
    assert (await site.gateway()).get("/robot1") == LEFT
    await other.replace("/robot1", NO_LABEL)
    assert other.get("/robot1") == NO_LABEL
    await until(lambda: one.get("/robot1") == NO_LABEL)
    assert await site.store.read() == {}


@pytest.mark.parametrize(
    "name", ["Left forklift", "LEFT FORKLIFT", "\uff2ceft forklift", "/robot2", "robot2", "Robot2/", "/"]
)
async def test_a_display_name_belongs_to_one_robot(site: Site, name: str) -> None:
    labels = await site.gateway()
    await labels.replace("/not/there/yet", LEFT)
    await labels.replace("/robot1", RobotLabel(None, ("hall 2",)))
    with pytest.raises(Conflict) as refused:
        await labels.replace("/robot1", RobotLabel(name, ()))
    assert refused.value.code == "display_name_taken"
    assert labels.get("/robot1") == RobotLabel(None, ("hall 2",))
    assert await site.store.read() == {"/not/there/yet": LEFT, "/robot1": RobotLabel(None, ("hall 2",))}


async def test_a_name_that_another_gateway_has_just_given_is_taken(site: Site) -> None:
    one, other = [await site.gateway(sync_interval=3600.0) for _ in range(2)]
    await one.replace("/robot1", LEFT)
    with pytest.raises(Conflict):
        await other.replace("/robot2", LEFT)
    await other.replace("/late", RobotLabel(None, ("hall 1",)))
    with pytest.raises(Conflict):  # that robot is known by its label only
        await one.replace("/robot2", RobotLabel("Late", ()))


async def test_a_robot_keeps_its_own_name(site: Site) -> None:
    labels = await site.gateway()
    for name in ("Left forklift", "left forklift", "/robot1", "ROBOT1"):
        await labels.replace("/robot1", RobotLabel(name, ("hall 1",)))
        assert labels.get("/robot1").display_name == name


async def test_without_the_history_nothing_changes(site: Site) -> None:
    labels = await site.gateway()
    await labels.replace("/robot1", LEFT)
    site.store.away = True
    for label in (NO_LABEL, RobotLabel("Right forklift", ())):
        with pytest.raises(Unavailable) as refused:
            await labels.replace("/robot1", label)
        assert refused.value.code == "history_unavailable"
    assert labels.get("/robot1") == LEFT
    late = await site.gateway()
    assert late.get("/robot1") == NO_LABEL
    site.store.away = False
    await until(lambda: late.get("/robot1") == LEFT)


async def test_there_are_not_endlessly_many(site: Site) -> None:
    labels = await site.gateway(most=1)
    await labels.replace("/robot1", LEFT)
    with pytest.raises(Conflict) as refused:
        await labels.replace("/robot2", RobotLabel("Right forklift", ()))
    assert refused.value.code == "limit_reached"
    await labels.replace("/robot2", NO_LABEL)
    await labels.replace("/robot1", RobotLabel("Right forklift", ()))
    await labels.replace("/robot1", NO_LABEL)
    await labels.replace("/robot2", LEFT)
