"""Run the benchmark: `make bench`, or `python -m benchmarks --help` in its environment."""

import gc
import sys
import time
from collections.abc import Awaitable, Callable, Sequence
from contextlib import ExitStack
from datetime import UTC, datetime
from typing import Any

import orjson
import uvloop

from benchmarks.cameras import cameras
from benchmarks.cases import FAILURES, acceptance, fan_out, highest_rate, latency
from benchmarks.costs import costs
from benchmarks.figures import Results
from benchmarks.machine import describe, wait_until_quiet
from benchmarks.options import Options, read_options
from benchmarks.plot import plot
from benchmarks.recordings import recordings
from benchmarks.requests import requests
from benchmarks.robots import robots
from benchmarks.site import Site, site
from benchmarks.startup import startup
from benchmarks.systems import LEFT_OUT
from benchmarks.systems.bare import Bare
from benchmarks.systems.base import System
from benchmarks.systems.gateway import Gateway, GatewayInMemory, GatewayWithTokens, RecordingGateway
from benchmarks.systems.http_gateway import HttpGateway
from benchmarks.systems.rosbridge import Rosbridge, RosbridgeSuite
from benchmarks.table import table
from benchmarks.topics import topics

Case = Callable[[Results, Sequence[Any], Options], Awaitable[None]]

RUNNING: dict[str, Case] = {
    "a": acceptance,
    "b": latency,
    "c": fan_out,
    "d": highest_rate,
    "h": topics,
    "i": cameras,
    "k": costs,
}


def _own(stack: ExitStack, options: Options, robots: int = 0) -> list[Bare | Gateway]:
    """The bare client and the versions of the gateway, each at a site of its own."""
    return [Bare(_site(stack, options, robots)), *_gateways(stack, options, robots)]


def _gateways(stack: ExitStack, options: Options, robots: int = 0) -> list[Gateway]:
    gateways = [Gateway(_site(stack, options, robots), variant) for variant in (*options.variants, None)]
    return [*gateways, *([GatewayWithTokens(_site(stack, options, robots))] if options.tokens else [])]


def _site(stack: ExitStack, options: Options, robots: int = 0) -> Site:
    return stack.enter_context(site(options.payload, robots))


def _peers(
    stack: ExitStack, options: Options, results: Results, of: Sequence[type[System]] = (HttpGateway, Rosbridge)
) -> list[System]:
    """The peers that are installed, each at a site of its own."""
    peers: list[System] = []
    if options.peers is None:
        return peers
    for name, why in LEFT_OUT.items():
        if not (options.peers / name).is_dir():
            results.leave_out(name, "", why)
    for peer in of:
        prefix = options.peers / peer.name
        if prefix.is_dir():
            peers.append(peer(stack.enter_context(site(options.payload)), prefix))
        elif peer.name not in LEFT_OUT:
            results.leave_out(peer.name, "", "it could not be installed from PyPI")
    return peers


async def _run(options: Options, results: Results) -> None:
    if set(options.cases) & set("abcde"):
        with ExitStack() as stack:
            systems = [*_own(stack, options), *_peers(stack, options, results)]
            if "e" in options.cases:
                _say("e")
                await startup(results, systems, options)
            await _run_together(options, results, systems, "abcd")
    if "f" in options.cases:
        _say("f")
        with ExitStack() as stack:
            await robots(results, _own(stack, options, options.robots), options)
    if "g" in options.cases:
        _say("g")
        with ExitStack() as stack:
            await requests(results, _gateways(stack, options), GatewayInMemory(_site(stack, options)), options)
    if "j" in options.cases:
        _say("j")
        with ExitStack() as stack:
            systems = [RecordingGateway(_site(stack, options), record) for record in ("none", "all")]
            await recordings(results, systems, options)
    if "k" in options.cases:
        with ExitStack() as stack:
            in_memory = GatewayInMemory(_site(stack, options))
            systems = [*_own(stack, options), in_memory, *_peers(stack, options, results, (HttpGateway,))]
            await _run_together(options, results, systems, "k")
    if "h" in options.cases:
        with ExitStack() as stack:
            systems = [*_gateways(stack, options), *_peers(stack, options, results, (Rosbridge, RosbridgeSuite))]
            await _run_together(options, results, systems, "h")
    if "i" in options.cases:
        with ExitStack() as stack:
            await _run_together(options, results, _gateways(stack, options), "i")


async def _run_together(options: Options, results: Results, systems: Sequence[System], of: str) -> None:
    """Run those of some cases that are wanted; all systems stay up."""
    cases = [case for case in options.cases if case in of]
    started: list[System] = []
    try:
        for system in systems if cases else ():
            try:
                await system.start()
                started.append(system)
            except FAILURES as why:
                results.leave_out(system.name, "", f"it did not start: {str(why) or type(why).__name__}")
                await system.close()
        for case in cases:
            _say(case)
            await RUNNING[case](results, started, options)
    finally:
        for system in started:
            await system.close()


def _say(case: str) -> None:
    print(f"case ({case}) …", file=sys.stderr, flush=True)


def main() -> None:
    """Measure, print the table, write JSON and plot."""
    options = read_options(sys.argv[1:])
    results = Results()
    begun = time.monotonic()
    gc.disable()
    busy = wait_until_quiet(options.quiet)
    uvloop.run(_run(options, results))
    text = table(results)
    print(text)
    options.output.mkdir(parents=True, exist_ok=True)
    run = {
        "at": datetime.now(UTC).isoformat(timespec="seconds"),
        "seconds": round(time.monotonic() - begun),
        "machine": {**describe(), "busy_before": round(busy, 3)},
        "options": {
            name: str(value) for name, value in vars(options).items() if name in ("cases", "rounds", "seconds")
        },
        **results.document(),
    }
    (options.output / "results.json").write_bytes(orjson.dumps(run, option=orjson.OPT_INDENT_2))
    (options.output / "table.md").write_text(text + "\n")
    plot(results, options.output / "latency.png", options.output / "latency.svg")
    print(f"\nwritten: results.json, table.md, latency.png and latency.svg in {options.output}", file=sys.stderr)


if __name__ == "__main__":
    main()
