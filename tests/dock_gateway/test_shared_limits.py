"""Each limit that users share has a share for each user: here is the list of all that bounds anything.

A new bound fails the first test until it is in the list: here, or in `bounds.txt` of an extension's tests. If users
share it, it belongs into `http.quotas.limits`, where the other tests find it.
"""

import asyncio
import math
import re
from collections import defaultdict
from contextlib import ExitStack
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.core.access import FORWARDER, Principal
from dock_gateway.core.errors import TooManyRequests
from dock_gateway.core.grant import Role
from dock_gateway.core.request import PERMIT, slot, turn
from dock_gateway.extension import extensions
from dock_gateway.http.quotas import TURNS, Quotas, limits
from dock_gateway.settings import Settings
from dock_hub.limits import hub_limits
from tests.support.bounds import OF_HUB, ROOT, bounds
from tests.support.permits import acting, permit, user

SHARES = "has a share for each user"
OF_CONNECTION = "of one connection, of which a user has a share"
OF_ADDRESS = "has a share for each address, below any login"
OF_USER = "of one user"
TURN = "waited for, after the user's own turn (`Quotas.turn`) or place (`Quotas.slot`)"
OLDEST_GO = "remembered or kept for the next time; the oldest go, and cost a little more then"
OF_GRAPH = "of what is on the ROS graph; no user makes more of it"
OF_GATEWAY = "of the gateway itself, or of one message, request or goal"
OF_SITES = "of what a hub sends; no user makes more of it"
STORED = "stored: who may add may also remove, and a lower role may not add"

REASONS = (SHARES, OF_CONNECTION, OF_ADDRESS, OF_USER, TURN, OLDEST_GO, OF_GRAPH, OF_GATEWAY, OF_SITES, STORED)

BOUNDS = {
    "access.login_guard:LoginGuard.counted": OF_ADDRESS,
    "access.passwords:": TURN,
    "core.fanout:Subscriber.put": OF_CONNECTION,
    "core.line:Line._insert": OLDEST_GO,
    "core.log_limit:LogLimit._forget": OLDEST_GO,
    "core.log_limit:LogLimit.filter": OF_GATEWAY,
    "core.work:Lane.__call__": SHARES,  # `large messages` come first
    "core.work:Work.__init__": OF_GATEWAY,
    "goals.adoption:Newcomers.hear": OF_GRAPH,
    "goals.cancellation:Canceler.mark_unwanted": OLDEST_GO,
    "goals.goal_machine:GoalMachine._note_ended": OLDEST_GO,
    "graph.earlier:EarlierMessages.add": OF_GRAPH,
    "graph.parameters:Parameters.__init__": TURN,
    "graph.parameters:Parameters._keep": OLDEST_GO,
    "graph.publishing:Publishing._replace": OLDEST_GO,
    "graph.service_calls:ServiceCalls._client": OLDEST_GO,
    "http.edge.forwarded:ForwardedHeaders._report": OF_GATEWAY,
    "http.edge.http:HttpProtocol.handle_websocket_upgrade": OF_ADDRESS,
    "http.edge.http:HttpProtocol.refuse_input": OF_ADDRESS,
    "http.edge.websocket:WebSocketProtocol.handle_events": OF_CONNECTION,
    "http.quotas:Quotas._require_room": SHARES,
    "http.quotas:Quotas.spend_goal": OF_USER,
    "http.quotas:Quotas.turn": OF_USER,
    "http.quotas:limits": SHARES,
    "latch.latch_file:LatchWriter.__init__": OF_GATEWAY,
    "robots.labels:Labels.replace.check": STORED,
    "ros.action_port:ActionPort.__init__": OF_GATEWAY,
    "ros.admission:Admission._find": OF_GRAPH,
    "ros.bridge:Bridge.branch": OF_GRAPH,
    "ros.inbox:Inbox._is_over_full": OF_GRAPH,
    "ros.inbox:Inbox.put": OF_GRAPH,
    "ros.losses:Losses.count": OF_GRAPH,
    "ros.parameter_reader:ParameterReader.messages": OF_GATEWAY,
    "sites.identity:Verifier._use": OF_SITES,  # 1,667 requests a second of one hub
    "sites.tunnel.answer:Asker.send": OF_GATEWAY,
    "sites.tunnel.caller:Caller._open": SHARES,  # `requests` and `requests of one` come first
    "sites.tunnel.server:TunnelServer._open": OF_SITES,  # more than `requests of one`
    "sites.tunnel.unsealed:Unsealed.put": OF_SITES,
    "storage.notes:_require_room": STORED,
    "storage.shared_entries:SharedBook.replace.check": STORED,
    "storage.spool:Files.__init__": OF_GATEWAY,
    "storage.keys:IdempotencyKeys._hold": OLDEST_GO,
    "storage.sqlite:SqliteDatabase.__init__": TURN,
    "streams.socket:CommandSession.subscribe": OF_CONNECTION,
    "streams.socket_session:SocketSession.read": OF_CONNECTION,
}

SOURCE = "".join(path.read_text() for root in (ROOT, OF_HUB) for path in root.rglob("*.py"))
TAKING_TURNS = sorted(set(re.findall(r'turn\("([^"]+)"', SOURCE)))
OF_A_HUB = hub_limits(Settings())
FURTHER = {**extensions().limits(Settings()), **OF_A_HUB}
LIMITS = {**limits(Settings()), **FURTHER}
NONE = "\N{EN DASH}"
# Those of which all users together have a number. `exports` are the others' business only by their number of users.
COMMON = sorted(what for what, limit in LIMITS.items() if limit.most < math.inf)
VIEWER, OTHER = user("viewer", Role.VIEWER), user("other", Role.VIEWER)
OPERATOR, ADMIN = user("operator", Role.OPERATOR), user("admin")
HERE, THERE = user(None, address="192.0.2.1"), user(None, address="192.0.2.2")
THE_HUB = user(FORWARDER, Role.OPERATOR)


def test_the_list_has_every_bound() -> None:
    pages = (Path(__file__).parents[1] / "extensions").glob("*/bounds.txt")
    of_extensions = [line.partition(" ") for page in pages for line in page.read_text().splitlines()]
    assert bounds() == {*BOUNDS, *(bound for bound, _, _ in of_extensions)}
    assert {reason for _, _, reason in of_extensions} <= set(REASONS)


def test_each_share_is_taken_somewhere() -> None:
    assert set(re.findall(r'slot\((?:\w+(?:\(\w*\))?, )?"([^"]+)"', SOURCE)) == set(LIMITS)
    assert set(TURNS) < set(TAKING_TURNS)


PAGES = {"configuration.md": {**limits(Settings()), **OF_A_HUB}} | {
    f"extensions/{extension.name}.md": extension.limits(Settings())
    for extension in extensions()
    if extension.limits(Settings())
}


@pytest.mark.parametrize("page", PAGES)
def test_the_documentation_has_every_share(page: str) -> None:
    """In the order of the list: of all, of a user, of an address, the reserve, and the error."""
    text = (Path(__file__).parents[2] / "docs" / page).read_text()
    table = text.partition("## Shares of users")[2].partition("|---")[2].partition("\n\n")[0].splitlines()[1:]
    rows = [[cell.strip() for cell in row.strip("| ").split("|")][1:] for row in table]
    for limit, (most, share, of_address, reserve, code) in zip(PAGES[page].values(), rows, strict=True):
        numbers = (limit.most, limit.share, limit.share_of(HERE), limit.reserve or math.inf)
        texts = (NONE if number == math.inf else str(number) for number in numbers)
        assert [each.partition(",")[0].partition(" ")[0] for each in (most, share, of_address, reserve)] == [*texts]
        assert code == f"`{limit.code}`"


def fill(stack: ExitStack, quotas: Quotas, who: Principal, what: str) -> int:
    """Let someone take as many places as they can; return how many."""
    codes: list[str] = []
    for number in range(int(LIMITS[what].most) + 1):
        try:
            stack.enter_context(quotas.slot(who, what, f"{who.name} {number}", "it"))
        except TooManyRequests as error:
            codes.append(error.code)
    assert set(codes) == {LIMITS[what].code}
    return int(LIMITS[what].most) + 1 - len(codes)


@pytest.mark.parametrize("what", COMMON)
def test_what_one_user_takes_is_not_all(what: str) -> None:
    """Whoever it is, another user with the same role still has a place, and those who stop and see have theirs."""
    for greedy, other in ((VIEWER, OTHER), (OPERATOR, user("another", Role.OPERATOR)), (ADMIN, user("eve"))):
        with ExitStack() as stack:
            quotas = Quotas(Settings(), FURTHER)
            assert fill(stack, quotas, greedy, what) == LIMITS[what].share
            for each in (other, OPERATOR if greedy != OPERATOR else ADMIN, ADMIN if greedy != ADMIN else OPERATOR):
                with quotas.slot(each, what, "more", "it"):
                    pass
            with pytest.raises(TooManyRequests, match=f"{greedy.name} already has .* share of one user"):
                stack.enter_context(quotas.slot(greedy, what, "more", "it"))


@pytest.mark.parametrize("what", COMMON)
def test_viewers_together_leave_the_reserve(what: str) -> None:
    limit = LIMITS[what]
    with ExitStack() as stack:
        quotas = Quotas(Settings(), FURTHER)
        viewers = (user(f"viewer{number}", Role.VIEWER) for number in range(math.ceil(limit.most / limit.share)))
        assert sum(fill(stack, quotas, each, what) for each in viewers) == limit.most - limit.reserve
        with pytest.raises(TooManyRequests, match="all users together have"):
            stack.enter_context(quotas.slot(OTHER, what, "more", "it"))
        if limit.reserve:
            assert fill(stack, quotas, ADMIN, what) == min(limit.share, limit.reserve)


@pytest.mark.parametrize("what", COMMON)
def test_without_a_login_another_address_still_has_a_place(what: str) -> None:
    with ExitStack() as stack:
        quotas = Quotas(Settings(), FURTHER)
        assert fill(stack, quotas, HERE, what) == LIMITS[what].share_of(HERE) < LIMITS[what].most
        with quotas.slot(THERE, what, "more", "it"):
            pass
        with pytest.raises(TooManyRequests, match=r"clients at 192\.0\.2\.1 already have .* share of one address"):
            stack.enter_context(quotas.slot(HERE, what, "more", "it"))


def test_the_hub_follows_its_site_as_long_as_there_is_a_place() -> None:
    with ExitStack() as stack:
        assert fill(stack, Quotas(Settings(), FURTHER), THE_HUB, "streams") == LIMITS["streams"].most


Step = tuple[Principal, str, int]
STEPS = st.lists(
    st.tuples(st.sampled_from([VIEWER, OTHER, OPERATOR, ADMIN, HERE]), st.sampled_from("abcdefgh"), st.integers(0, 2)),
    max_size=60,
)


@given(STEPS, st.integers(2, 8), st.integers(1, 4), st.integers(0, 3))
def test_no_order_of_holds_breaks_a_share(steps: list[Step], most: int, share: int, reserve: int) -> None:
    """Whatever is held and given back: nobody has more than their share, all no more than there is, viewers no more
    than is not reserved, nothing is refused without need, and in the end nothing is left."""
    limit = LIMITS["topics"].__class__("topics", most, share, min(reserve, most - 1))
    quotas = Quotas(Settings(), {**FURTHER, "topics": limit})
    held: defaultdict[Principal, list[tuple[str, ExitStack]]] = defaultdict(list)
    for who, topic, give in steps:
        own = {each for each, _ in held[who]}
        everyone = {each for places in held.values() for each, _ in places}
        if give and held[who]:
            held[who].pop(0)[1].close()
            continue
        room = topic in own or (
            len(own) < limit.share_of(who) and (topic in everyone or len(everyone) < limit.open_to(who))
        )
        place = ExitStack()
        if room:
            place.enter_context(quotas.slot(who, "topics", topic))
            held[who].append((topic, place))
        else:
            with pytest.raises(TooManyRequests):
                place.enter_context(quotas.slot(who, "topics", topic))
    for places in held.values():
        for _, place in places:
            place.close()
    with ExitStack() as stack:
        assert fill(stack, quotas, ADMIN, "topics") == min(limit.share_of(ADMIN), limit.open_to(ADMIN))


def test_a_topic_of_several_connections_and_users_takes_one_place() -> None:
    quotas = Quotas(Settings(), FURTHER)
    with ExitStack() as stack:
        for who in (VIEWER, VIEWER, OTHER):
            stack.enter_context(quotas.slot(who, "topics", "/scan", "it"))
        assert fill(stack, quotas, VIEWER, "topics") == LIMITS["topics"].share_of(VIEWER) - 1
    with ExitStack() as stack:
        assert fill(stack, quotas, VIEWER, "topics") == LIMITS["topics"].share_of(VIEWER)


@pytest.mark.parametrize("what", TAKING_TURNS)
async def test_a_user_waits_for_their_own_turn_before_those_of_others(what: str) -> None:
    """One user asks a hundred times at once; another one, later, is next."""
    quotas, shared, order = Quotas(Settings(), FURTHER), asyncio.Semaphore(TURNS.get(what, 1)), list[str]()

    async def ask(who: Principal) -> None:
        PERMIT.set(permit(quotas, who))
        async with turn(what), shared:
            await asyncio.sleep(0)
            order.append(str(who.name))

    many = [asyncio.create_task(ask(VIEWER)) for _ in range(100)]
    await asyncio.sleep(0)
    await asyncio.gather(ask(ADMIN), *many)
    assert order.index("admin") <= 2 * TURNS.get(what, 1)
    await asyncio.gather(*(ask(VIEWER) for _ in range(TURNS.get(what, 1) + 1)))  # all turns are given back


def test_what_the_gateway_does_by_itself_needs_no_place() -> None:
    with ExitStack() as stack:
        for _ in range(1000):
            stack.enter_context(slot("topics"))
        with acting(Quotas(Settings(), FURTHER), VIEWER):
            assert sum(1 for _ in range(75) if stack.enter_context(slot("topics")) is None) == 75
            with pytest.raises(TooManyRequests):
                stack.enter_context(slot("topics"))
