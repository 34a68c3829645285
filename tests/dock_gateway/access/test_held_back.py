"""A request whose body is held back acts with the login of the moment at which it acts."""

import asyncio
from datetime import datetime, timedelta

import orjson
import pytest
from fastapi.routing import APIRoute

from dock_gateway.app import api_routers
from dock_gateway.core.event import utc_now
from dock_gateway.core.grant import Grant, Role
from dock_gateway.extension import extensions
from dock_gateway.http.operation import operation_of
from dock_gateway.settings import Settings
from tests.support.held_back import PASSWORD, Change, Site, log_out
from tests.support.history import make_goal
from tests.support.waiting import until

CHANGES = [
    (method, route.path, route.name)
    for router in api_routers(Settings(), extensions())
    for route in router.routes
    if isinstance(route, APIRoute)
    for method in route.methods
    if operation_of(route.endpoint).role is not None
]

pytestmark = pytest.mark.usefixtures("quick_hashes")


async def disable(site: Site) -> None:
    await site.logins.accounts.edit("ada", disabled=True)


async def remove(site: Site) -> None:
    await site.logins.accounts.remove("ada")


async def change_password(site: Site) -> None:
    await site.logins.accounts.edit("ada", password="another horse, another battery")


async def demote(site: Site) -> None:
    await site.logins.accounts.edit("ada", Grant(Role.VIEWER))


async def limit(site: Site) -> None:
    await site.logins.accounts.edit("ada", Grant(Role.OPERATOR, ("/robot7",)))


@pytest.mark.parametrize(("method", "path", "name"), CHANGES)
async def test_no_route_acts_for_a_login_that_ended_while_the_body_came(method: str, path: str, name: str) -> None:
    """Whichever the route: those that were let through find nothing, and answer otherwise."""
    site = await Site().open()
    answer = await site.ask(method, path, meanwhile=log_out)
    if name in {"stop", "cancel_goal", "cancel_mission"}:  # they stop something: carried out by their head
        assert answer[0] not in (401, 403)
        return
    assert answer == (401, "invalid_token")


@pytest.mark.parametrize(
    ("change", "answer"),
    [
        (log_out, (401, "invalid_token")),
        (disable, (401, "invalid_token")),
        (remove, (401, "invalid_token")),
        (change_password, (401, "invalid_token")),
        (demote, (403, "role_required")),
        (limit, (403, "role_required")),
    ],
)
@pytest.mark.parametrize(("method", "path"), [("PUT", "/users/{user}"), ("POST", "/tokens")])
async def test_what_changes_while_a_body_comes(change: Change, answer: tuple[int, str], method: str, path: str) -> None:
    site = await Site().open()
    body = {"name": "x", "role": "admin"} if method == "POST" else {"role": "admin", "password": PASSWORD}
    assert await site.ask(method, path, orjson.dumps(body), meanwhile=change) == answer
    assert {user["name"] for user in await site.logins.accounts.documents()} <= {"ada", "root"}
    assert await site.logins.tokens.documents() == []
    entry = site.audit.entries[-1]
    assert (entry.status, entry.code) == answer


async def test_a_limit_that_was_set_while_a_body_came() -> None:
    site = await Site().open()
    assert await site.ask("POST", "/actions/{name:graph_name}/goals", meanwhile=limit) == (403, "not_allowed")


async def test_a_role_that_still_suffices() -> None:
    site = await Site().open()

    async def lower(site: Site) -> None:
        await site.logins.accounts.edit("ada", Grant(Role.OPERATOR))

    assert (await site.ask("POST", "/dock", meanwhile=lower))[0] == 404


async def test_a_token_that_expires_while_a_body_comes() -> None:
    site = await Site().open()
    expires_at = utc_now() + timedelta(seconds=0.2)
    _, site.secret = await site.logins.create_token("brief", Grant(Role.ADMIN), expires_at)

    async def expire(_: Site) -> None:
        await until(lambda: utc_now() >= expires_at)

    body = orjson.dumps({"role": "admin", "password": PASSWORD})
    assert await site.ask("PUT", "/users/{user}", body, meanwhile=expire) == (401, "invalid_token")


async def test_a_login_that_ends_while_the_password_is_hashed() -> None:
    """Others hash theirs first: the body was there long before."""
    site = await Site().open()
    others = [
        asyncio.create_task(site.logins.accounts.add(f"user{n}", Grant(Role.VIEWER), PASSWORD)) for n in range(50)
    ]
    body = orjson.dumps({"role": "admin", "password": PASSWORD})
    change = asyncio.create_task(site.ask("PUT", "/users/{user}", body))
    await asyncio.sleep(0)
    await log_out(site)
    assert await change == (401, "invalid_token")
    await asyncio.gather(*others)
    assert "x1" not in {user["name"] for user in await site.logins.accounts.documents()}


async def test_the_record_says_when_it_acted() -> None:
    site = await Site().open()
    whole: list[datetime] = []

    async def note(_: Site) -> None:
        whole.append(utc_now())

    requests = [("PUT", "/users/{user}", {"role": "viewer", "password": PASSWORD}), ("POST", "/session", {"token": ""})]
    for method, path, body in requests:
        await site.ask(method, path, orjson.dumps(body), meanwhile=note)
        assert site.audit.entries[-1].acted_at >= whole[-1]


async def test_a_body_is_asked_for_only_if_the_head_may_send_it() -> None:
    """As `Expect: 100-continue` has it: the server asks when the body is read for the first time."""
    site = await Site().open()

    async def never(_: Site) -> None:
        raise AssertionError("the body of a stranger was read")

    stranger = {"authorization": "Bearer dgw_x"}
    assert await site.ask("POST", "/dock", meanwhile=never, **stranger) == (401, "invalid_token")
    body = b"x" * (site.settings.max_body_bytes + 1)
    assert await site.ask("POST", "/dock", body, meanwhile=never) == (413, "body_too_large")


async def test_an_export_ends_with_the_login() -> None:
    """Its client cannot take the part for the whole."""
    site = await Site().open()
    for number in range(1200):
        site.history.record(make_goal(number))
    whole = await site.read("/goals/export")
    assert len(orjson.loads(whole)) == 1200
    part = await site.read("/goals/export", after_a_piece=log_out)
    assert 0 < len(part) < len(whole)
    with pytest.raises(orjson.JSONDecodeError):
        orjson.loads(part)
