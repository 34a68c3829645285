"""Case (g): what the gateway itself adds to a request, and what its database adds to a goal."""

from contextlib import AsyncExitStack

from benchmarks.cases import acceptance, take_turns
from benchmarks.figures import Results
from benchmarks.options import Options
from benchmarks.systems.gateway import Gateway, GatewayInMemory
from benchmarks.systems.stock import Stock

CASE = "(g) request"
REQUESTS = 500


async def requests(results: Results, gateways: list[Gateway], in_memory: GatewayInMemory, options: Options) -> None:
    """`GET /healthz` beside a server of one route, and goals beside a gateway whose history is in memory."""

    async def measure(system: Stock | Gateway) -> None:
        for _ in range(20):
            system.healthz()
        timings = (system.healthz() for _ in range(REQUESTS))
        results.latencies(CASE, "GET /healthz", system.name, timings)

    stock = Stock()
    systems: list[Stock | Gateway] = [stock, *gateways, in_memory]
    async with AsyncExitStack() as stack:
        for system in systems:
            stack.push_async_callback(system.close)
            await system.start()
        await take_turns(results, CASE, [stock, *gateways], options, measure)
        await acceptance(results, [*gateways, in_memory], options, CASE)
