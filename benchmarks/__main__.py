"""Run the benchmark: `make bench`, or `python -m benchmarks --help` in its environment."""

import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from datetime import UTC, datetime
from functools import partial

import orjson
import uvloop

from benchmarks.cases import acceptance, fan_out, highest_rate, latency
from benchmarks.figures import Results
from benchmarks.machine import describe, wait_until_quiet
from benchmarks.options import Options, read_options
from benchmarks.plot import plot
from benchmarks.robots import robots
from benchmarks.site import Site, site
from benchmarks.startup import startup
from benchmarks.systems.bare import Bare
from benchmarks.systems.base import Impossible, System
from benchmarks.systems.gateway import Gateway
from benchmarks.systems.http_gateway import HttpGateway
from benchmarks.systems.rosbridge import Rosbridge
from benchmarks.table import table

RUNNING = {"a": acceptance, "b": latency, "c": fan_out, "d": highest_rate}


def _makers(stack: ExitStack, options: Options) -> list[Callable[[], System]]:
    """What makes each system, each at a site of its own."""

    def where() -> Site:
        return stack.enter_context(site(options.payload))

    makers: list[Callable[[], System]] = [partial(Bare, where())]
    makers += [partial(Gateway, where(), variant) for variant in options.variants]
    makers.append(partial(Gateway, where()))
    if options.peers:
        makers.append(partial(HttpGateway, where(), options.peers / "ros2-http-gateway", options.rosidl_runtime_py))
        makers.append(partial(Rosbridge, where(), options.peers / "rosbridge-server-rs"))
    return makers


async def _run(options: Options, results: Results) -> None:
    with ExitStack() as stack:
        if set(options.cases) & set("abcde"):
            makers = _makers(stack, options)
            if "e" in options.cases:
                _say("e")
                await startup(results, makers, options)
            await _run_together(options, results, makers)
    if "f" in options.cases:
        _say("f")
        await robots(results, options)


async def _run_together(options: Options, results: Results, makers: list[Callable[[], System]]) -> None:
    cases = [case for case in options.cases if case in RUNNING]
    systems: list[System] = []
    try:
        for new in makers if cases else []:
            system = new()
            system.patience = 3
            systems.append(system)
            try:
                await system.start()
            except Impossible as why:
                results.missing("", "", system.name, str(why))
                systems.remove(system)
                await system.close()
        for case in cases:
            _say(case)
            await RUNNING[case](results, systems, options)
    finally:
        for system in systems:
            await system.close()


def _say(case: str) -> None:
    print(f"case ({case}) …", file=sys.stderr, flush=True)


def main() -> None:
    """Measure, print the table, write JSON and plot."""
    options = read_options(sys.argv[1:])
    results = Results()
    begun = time.monotonic()
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
        "figures": results.document(),
    }
    (options.output / "results.json").write_bytes(orjson.dumps(run, option=orjson.OPT_INDENT_2))
    (options.output / "table.md").write_text(text + "\n")
    plot(results, options.output / "latency.png", options.output / "latency.svg")
    print(f"\nwritten: results.json, table.md, latency.png and latency.svg in {options.output}", file=sys.stderr)


if __name__ == "__main__":
    main()
