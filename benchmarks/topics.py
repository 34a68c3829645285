"""Case (h): one topic to many clients of rosbridge's protocol, in JSON and in CBOR."""

import asyncio
from collections.abc import Sequence
from functools import partial

import orjson
from picows import WSMsgType, WSTransport

from benchmarks.cases import take_turns
from benchmarks.figures import Results
from benchmarks.machine import Cpu
from benchmarks.options import Options
from benchmarks.readers import Tally, WebSocketReader, connect
from benchmarks.site import ACTION, ACTION_TYPE, Goal
from benchmarks.systems.base import Impossible
from benchmarks.systems.gateway import Gateway
from benchmarks.systems.rosbridge import Rosbridge

MARK = b'"publish"'  # with a space before it or without
TOPIC, TYPE = "/benchmark", "sensor_msgs/msg/BatteryState"
LOADS = ((1, 1000), (50, 200), (200, 100))  # readers, Hz
COMPRESSIONS = {"JSON": "none", "CBOR": "cbor"}


async def topics(results: Results, systems: Sequence[Gateway | Rosbridge], options: Options) -> None:
    """Deliver the messages of a topic. The clients are those of the protocol: they do not know whose server it is."""
    for readers, rate in LOADS:
        goal = Goal(rate, int(rate * options.seconds), 0.5 + readers / 800)
        for name, compression in COMPRESSIONS.items():
            case = f"(h) {readers} x {rate} Hz, {name}"
            measure = partial(_measure, results, case, goal, readers, compression=compression)
            await take_turns(results, case, systems, options, measure)


async def _measure(
    results: Results, case: str, goal: Goal, readers: int, system: Gateway | Rosbridge, *, compression: str
) -> None:
    tally, expected = Tally(), goal.count * readers
    transports: list[WSTransport] = []
    try:
        while len(transports) < readers:
            transport, _ = await connect(system.rosbridge_url, lambda: WebSocketReader(tally, MARK))
            transports.append(transport)
            _send(transport, op="subscribe", topic=TOPIC, type=TYPE, compression=compression)
        before = Cpu.of(system.pid)
        args = {"desired_battery_state": {**goal.state, "location": "topic"}}
        _send(transports[0], op="send_action_goal", id="h", action=f"/{ACTION}", action_type=ACTION_TYPE, args=args)
        await asyncio.sleep(goal.delay + goal.seconds)
        await tally.settle(expected)
        used = Cpu.of(system.pid).seconds - before.seconds
    finally:
        for transport in transports:
            transport.disconnect()
    received = len(tally.latencies)
    if not received:
        raise Impossible(f"it delivered none of {expected} messages")
    results.add(case, "delivered", system.name, received / ((tally.last_ns - min(tally.stamps)) / 1e9), "messages/s")
    results.add(case, "CPU of 1,000 delivered", system.name, 1e6 * used / received, "ms")
    results.latencies(case, "", system.name, tally.latencies[received // 10 :])
    results.add(case, f"lost of {expected}", system.name, max(0, expected - received), "lost")


def _send(transport: WSTransport, **operation: object) -> None:
    transport.send(WSMsgType.TEXT, orjson.dumps(operation))
