"""`/ws/topics`: the messages of any topic, and their rate."""

from contextlib import AsyncExitStack

from fastapi import APIRouter, WebSocket

from dock_gateway.core.errors import FieldError, GatewayError, InvalidField
from dock_gateway.core.filters import EventFilter
from dock_gateway.web.problems import problem_response
from dock_gateway.web.queries import read_max_rate
from dock_gateway.web.requests import TheGateway, known_query
from dock_gateway.web.streams.events import ignore_input, until_one_ends, write_events
from dock_gateway.web.streams.feed import follow

router = APIRouter()

MIN_RATE, MAX_RATE, USUAL_RATE = 0.1, 20.0, 5.0


@router.websocket("/ws/topics")
async def echo_topic(websocket: WebSocket, gateway: TheGateway) -> None:
    """Send a topic's endpoints, its newest messages, and once a second the rate of all its messages.

    `?topic=` names the topic; `?max_rate=` limits how many messages per second are shown.
    """
    query = websocket.query_params
    async with AsyncExitStack() as stack:
        try:
            await known_query("topic", "max_rate")(websocket)
            if not (name := query.get("topic", "")):
                raise InvalidField([FieldError("query.topic", "the name of a topic", "got none")])
            max_rate = read_max_rate(query, MIN_RATE, MAX_RATE) or USUAL_RATE
            subscriber = gateway.hub.subscribe(EventFilter(topics=frozenset()))
            stack.callback(gateway.hub.unsubscribe, subscriber)
            await stack.enter_async_context(
                gateway.echoes.watch(gateway.settings.resolve(name, ""), subscriber, max_rate)
            )
        except GatewayError as error:
            await websocket.send_denial_response(problem_response(error))
            return
        await websocket.accept()
        await until_one_ends(
            write_events(websocket, gateway, subscriber, follow(gateway, subscriber)), ignore_input(websocket)
        )
