"""An agent's goal waits for a person: for this goal, once, not for long, and not beyond a stop."""

import asyncio
from types import SimpleNamespace
from typing import Any

import pytest

from dock_gateway.core.access import Principal, PrincipalKind
from dock_gateway.core.errors import Conflict, GatewayError, NotAllowed, NotAuthenticated, NotFound, TooManyRequests
from dock_gateway.core.grant import Grant, Role
from dock_gateway.core.request import PERMIT
from dock_gateway.goals.approvals import Approvals
from dock_gateway.http.quotas import Quotas
from dock_gateway.settings import Settings
from tests.support.permits import acting, permit, user

ROBOT, ACTION = "/robot1", "/robot1/dock"


class Site:
    """Approvals of a robot, and what they publish."""

    def __init__(self, timeout: float = 60.0, **settings: Any) -> None:
        self.published: list[Any] = []
        self.simulated: set[str] = set()
        fanout: Any = SimpleNamespace(watched=lambda _: True, publish=self.published.append)
        settings_of = Settings(approval_timeout=timeout, **settings)
        self.approvals = Approvals(settings_of, fanout, lambda _: "dock", lambda robot: robot in self.simulated)

    def ask(self, name: str = "bot", action: str = ACTION) -> "asyncio.Task[None]":
        return asyncio.create_task(self.approvals.require(agent(name), action, b'{"order":1}'))

    async def waiting(self, number: int = 1) -> list[dict[str, Any]]:
        for _ in range(1000):
            if len(documents := self.approvals.documents()) == number:
                return documents
            await asyncio.sleep(0)
        raise AssertionError(f"there are {len(documents)}")


def agent(name: str | None) -> Principal:
    return Principal(name, PrincipalKind.TOKEN, Grant(Role.AGENT), "id")


async def test_it_is_answered_once() -> None:
    site = Site()
    for allow in (True, False):
        asking = site.ask()
        (document,) = await site.waiting()
        assert (document["agent"], document["verb"], document["robot"]) == ("bot", "dock", ROBOT)
        site.approvals.decide(document["id"], allow=allow, by="ada")
        with pytest.raises(NotFound):
            site.approvals.decide(document["id"], allow=True, by="ada")
        if allow:
            await asking
        else:
            with pytest.raises(NotAllowed, match="ada has refused the goal"):
                await asking
        assert site.approvals.documents() == []
    assert len(site.published) == 4


async def test_a_grant_sees_its_own() -> None:
    site = Site()
    asking = site.ask()
    (document,) = await site.waiting()
    other = Grant(Role.OPERATOR, robots=("/robot2",))
    assert site.approvals.documents(other) == []
    with pytest.raises(NotFound):
        site.approvals.get(document["id"], other)
    asking.cancel()


async def test_it_expires() -> None:
    with pytest.raises(NotAllowed) as error:
        await Site(timeout=0.01).ask()
    assert error.value.code == "approval_expired"


@pytest.mark.parametrize(("stopped", "dropped"), [("/", True), (ROBOT, True), ("/robot2", False), ("/robot10", False)])
async def test_a_stop_of_its_robot_drops_it(stopped: str, dropped: bool) -> None:
    site = Site()
    asking = site.ask()
    (document,) = await site.waiting()
    site.approvals.drop(stopped)
    if not dropped:
        site.approvals.decide(document["id"], allow=True, by=None)
        await asking
        return
    with pytest.raises(NotFound):  # at once: whoever allows it now is late
        site.approvals.decide(document["id"], allow=True, by=None)
    with pytest.raises(Conflict) as error:
        await asking
    assert error.value.code == "stopped"


async def test_the_end_of_the_gateway_or_of_the_login_drops_it() -> None:
    site = Site()
    asking = site.ask()
    await site.waiting()
    await site.approvals.close()
    with pytest.raises(GatewayError) as error:
        await asking
    assert error.value.code == "shutting_down"

    ended = False

    def require() -> None:
        if ended:
            raise NotAuthenticated("it has ended", code="invalid_token")

    ends: list[Any] = []

    class Watch:
        def __init__(self, end: Any) -> None:
            ends.append(end)

        def __enter__(self) -> None: ...

        def __exit__(self, *_: object) -> None: ...

    PERMIT.set(permit(require=require, watch=Watch))
    asking = site.ask()
    await site.waiting()
    ended = True
    ends[0]()
    with pytest.raises(NotAuthenticated):
        await asking
    assert site.approvals.documents() == []


async def test_few_wait() -> None:
    site = Site()
    quotas = Quotas(Settings())

    def ask(name: str) -> "asyncio.Task[None]":
        with acting(quotas, agent(name)):
            return site.ask(name)

    asking = [ask("bot") for _ in range(3)]
    await site.waiting(3)
    with pytest.raises(TooManyRequests, match="bot already has 3 goals waiting for a person: that is the share"):
        await ask("bot")
    asking += [ask(f"bot{number}") for number in range(7)]
    await site.waiting(10)
    with pytest.raises(TooManyRequests, match="all users together have 10 goals waiting for a person"):
        await ask("another")
    for each in asking:
        each.cancel()


async def test_only_what_is_surely_simulated_waits_for_nobody() -> None:
    site = Site(dock_action="/dock_robot")
    site.simulated = {ROBOT, "/"}
    await site.ask()
    real = ("/robot2/dock", "/robot1/arm/move", "/dock_robot")  # the last one serves every robot
    asking = [site.ask(str(number), action) for number, action in enumerate(real)]
    assert [each["action_name"] for each in await site.waiting(3)] == list(real)
    for each in asking:
        each.cancel()


async def test_requests_of_others_wait_for_nobody() -> None:
    for role in set(Role) - {Role.AGENT}:
        await Site().approvals.require(user("ada", role), ACTION, b"{}")
