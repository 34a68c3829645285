"""`/ws/topics`: the messages of any topic, and their rate."""

from fastapi import APIRouter, Depends, WebSocket

from dock_gateway.access.authorization import subscribed
from dock_gateway.core.errors import FieldError, InvalidField
from dock_gateway.core.filters import EventFilter
from dock_gateway.graph.relays import Relays
from dock_gateway.http.operation import carries_out
from dock_gateway.http.parts import AllParts
from dock_gateway.http.principal import TICKET, principal_of
from dock_gateway.http.quotas import Quotas
from dock_gateway.http.unexpected import known_query
from dock_gateway.operations.topics import subscribe
from dock_gateway.settings import Settings
from dock_gateway.streams.events import ignore_input, until_one_ends, write_events
from dock_gateway.streams.feed import follow
from dock_gateway.streams.queries import read_max_rate

router = APIRouter()

MIN_RATE, MAX_RATE, USUAL_RATE = 0.1, 20.0, 5.0


@router.websocket("/ws/topics", dependencies=[Depends(known_query("topic", "max_rate", TICKET))])
@carries_out(subscribe)
async def echo_topic(websocket: WebSocket, parts: AllParts) -> None:
    """Send a topic's endpoints, its newest messages, and once a second the rate of all its messages.

    `?topic=` names the topic; `?max_rate=` limits how many messages per second are shown.
    """
    query = websocket.query_params
    if not (name := query.get("topic", "")):
        raise InvalidField([FieldError("topic", "the name of a topic", "got none", "query")])
    max_rate = read_max_rate(query, MIN_RATE, MAX_RATE) or USUAL_RATE
    principal, topic = principal_of(websocket), parts[Settings].resolve(name, "")
    with (
        subscribed(parts, principal, EventFilter(topics=frozenset())) as subscriber,
        parts[Quotas].slot(principal, "views", topic),
    ):
        async with parts[Relays].watch(topic, subscriber, max_rate):
            await websocket.accept()
            events = write_events(websocket, parts, subscriber, follow(parts, subscriber))
            await until_one_ends(events, ignore_input(websocket))
