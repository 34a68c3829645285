"""Measure the dashboard in a browser: `make bench-dashboard`, or `python -m benchmarks.dashboard --help`."""

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from tests.browser.loading import first_visit
from tests.support.gateway import RunningGateway, running_gateway
from tests.support.processes import Process
from tests.support.waiting import wait_until

from benchmarks.dashboard.browser import Cost, Watched, opened_browser, watched
from benchmarks.machine import describe
from benchmarks.site import PRODUCT, ROOT, Goal, site

ENOUGH = 7200  # seconds that a goal's feedback goes on
WIDTHS = (1440, 768)  # of a desk and of a tablet
ROW = "| {:<44} | {:>8} | {:>8} | {:>10} | {:>10} |"
HEAD = ROW.format("page", "CPU %", "heap MB", "long tasks", "longest ms")
RULE = "|".join("-" * len(cell) for cell in HEAD.split("|"))


@contextmanager
def running(robots: int, rate: float) -> Iterator[str]:
    """A gateway, and robots whose batteries, goals and, where it is one, velocity have so many messages a second."""
    with ExitStack() as stack:
        where = stack.enter_context(site(robots=robots))
        if not robots:
            stack.enter_context(Process(str(PRODUCT / "bin/dock_simulator"), env=where.environment()))
        command = [str(PRODUCT / "bin/python"), str(ROOT / "benchmarks/nodes/fleet.py"), "--ros-args"]
        command += ["-p", f"robots:={robots}", "-p", f"rate:={rate}", "-p", f"drive:={str(not robots).lower()}"]
        fleet = stack.enter_context(Process(*command, env=where.environment(), cwd=ROOT))
        fleet.wait_for("publishing")
        gateway = stack.enter_context(running_gateway(where.domain))
        for number in range(1, robots + 1) or [None]:
            _send(gateway, number, Goal(rate, int(rate * ENOUGH)))
        yield gateway.url


def _send(gateway: RunningGateway, robot: int | None, goal: Goal) -> None:
    """Send a goal, as soon as the robot is known."""
    query = {} if robot is None else {"robot": f"/robot{robot}"}
    body = {"desired_battery_state": goal.state}
    wait_until(lambda: gateway.http.post("/dock", params=query, json=body).status_code == 202, f"a goal of {query}", 60)


def _row(name: str, cost: Cost) -> str:
    cells = (f"{cost.cpu:.0f}", f"{cost.heap:.1f}", cost.long_tasks, f"{cost.longest_ms:.0f}")
    return ROW.format(name, *cells)


def _long(page: Watched, minutes: float, say: Callable[[str], None]) -> None:
    """Memory over a longer time, a line every fifth of it."""
    for share in range(6):
        say(_row(f"the same after {share * minutes / 5:.0f} min", page.during(10)))
        if share < 5:
            page.page.wait_for_timeout(max(0.0, minutes * 12_000 - 10_000))


def main() -> None:
    """Measure, print the table and write it."""
    parser = argparse.ArgumentParser("benchmarks.dashboard", description="What the dashboard costs a browser")
    parser.add_argument("--seconds", type=float, default=20.0, help="length of one look (default: 20)")
    parser.add_argument("--minutes", type=float, default=0.0, help="watch the memory for so long (default: not)")
    parser.add_argument("--robots", type=int, default=100, help="of the fleet (default: 100)")
    parser.add_argument("--output", type=Path, default=ROOT / "benchmarks/results/dashboard.md")
    options = parser.parse_args()
    lines: list[str] = []

    def say(line: str) -> None:
        lines.append(line)
        sys.stdout.write(f"{line}\n")
        sys.stdout.flush()

    machine = describe()
    with running(0, 50.0) as url:
        say(f"{machine['cores']} cores, {machine['cpu']}.")
        with opened_browser() as browser:
            for width in WIDTHS:
                visit = first_visit(browser, url, width)
                kb, scripts = visit.transferred / 1000, visit.scripts / 1000
                say(f"First visit, {width} wide: {kb:.0f} kB, {scripts:.0f} of them scripts; shift {visit.shift:.4f}.")
        say("")
        say(HEAD)
        say(RULE)
        with watched(url) as page:
            say(_row("one robot: battery, feedback, velocity 50 Hz", page.during(options.seconds)))
            if options.minutes:
                _long(page, options.minutes, say)
    with running(options.robots, 2.0) as url, watched(url) as page:
        page.page.get_by_text(f"/robot{options.robots}", exact=True).first.wait_for(timeout=60_000)
        say(_row(f"{options.robots} robots: battery and feedback 2 Hz", page.during(options.seconds)))
    options.output.parent.mkdir(parents=True, exist_ok=True)
    options.output.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
