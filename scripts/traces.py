"""Writes the traces in docs/architecture.md: which files a request, a feedback message, a stop and a control step use.

They are those of a real gateway and a real docking server. It takes about half a minute.
"""

import json
import signal
import sys
import textwrap
from collections import Counter, defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import groupby
from pathlib import Path, PurePath
from tempfile import TemporaryDirectory

from scripts.follow import DOCK, FEEDBACK, STEP, STOP
from tests.support.clients import HttpClient
from tests.support.domain import ros_domain
from tests.support.gateway import LOW, PATIENT, RunningGateway
from tests.support.processes import Process, ros_environment

PAGE = Path(__file__).parents[1] / "docs/architecture.md"
BEGIN, END = "<!-- traces: python -m scripts.traces -->\n", "<!-- end of traces -->\n"
TITLES = {
    DOCK: "`POST /dock`, from its route to DDS",
    FEEDBACK: "Feedback, from DDS to a socket",
    STOP: "`POST /stop`, from its route to DDS",
    STEP: "A control step of docking, from its timer to `cmd_vel`",
}
ROUNDS = 5
USUAL = 0.5  # of the number of the most frequent traces of a kind

WIDTH = 126
FOLDER = 36

Trace = tuple[tuple[str, str], ...]


@contextmanager
def followed(domain: int, output: Path, *command: str, **variables: str) -> Iterator[Process]:
    """A program that writes its traces when the body has ended without an error."""
    environment = ros_environment(domain, **variables)
    with Process(sys.executable, "-m", "scripts.follow", str(output), *command, env=environment) as process:
        yield process
        process.send_signal(signal.SIGUSR1)
        process.wait_for("traces written")


def follow_gateway(domain: int, folder: Path) -> dict[str, list[Trace]]:
    """Dock and stop some times while a WebSocket listens."""
    output = folder / "gateway.json"
    settings = {
        "port": "0",
        "database_url": f"sqlite:///{folder}/history.db",
        "spool_path": f"{folder}/spool",
        "stop_path": f"{folder}/stops.json",
        **PATIENT,
    }
    variables = {f"DOCK_GATEWAY_{name.upper()}": value for name, value in settings.items()}
    with (
        Process("connect_to_charging_dock_server", env=ros_environment(domain)),
        followed(domain, output, "dock-gateway", "serve", **variables) as process,
    ):
        url = process.wait_for("listening on ").rpartition(" ")[2]
        with HttpClient(url) as http:
            gateway = RunningGateway(process, url, http)
            gateway.wait_until_ready()
            gateway.publish(LOW)
            for _ in range(ROUNDS):
                goal_id = http.post("/dock").raise_for_status().json()["goal_id"]
                with gateway.stream() as stream:
                    for _ in range(5):
                        stream.until_type("feedback")
                http.post("/stop").raise_for_status()
                gateway.wait_for_goal(goal_id, "canceled")
                http.delete("/stop").raise_for_status()
    return read(output)


def follow_docking(domain: int, folder: Path) -> dict[str, list[Trace]]:
    """Dock a simulated robot."""
    output = folder / "docking.json"
    environment = ros_environment(domain)
    server = ("docking_server", "--ros-args", "-p", "controller:=dock_pose")
    with Process("dock_simulator", env=environment), followed(domain, output, *server):
        with Process("connect_to_charging_dock_client", "--timeout", "60", env=environment) as client:
            code = client.wait(180)
        assert code == 0, client.output
    return read(output)


def read(output: Path) -> dict[str, list[Trace]]:
    """Return the traces that a program has written."""
    found = json.loads(output.read_text())
    return {kind: [tuple((file, function) for file, function in trace) for trace in found[kind]] for kind in found}


def usual(traces: list[Trace]) -> Trace:
    """Return the longest of the usual traces: what happens at the same moment by chance is in few of them."""
    by_files: defaultdict[frozenset[tuple[str, str]], list[Trace]] = defaultdict(list)
    for trace in traces:
        by_files[frozenset(trace)].append(trace)
    most = max(len(same) for same in by_files.values())
    common = [same for same in by_files.values() if len(same) >= most * USUAL]
    return Counter(max(common, key=lambda same: len(same[0]))).most_common(1)[0][0]


def steps(trace: Trace) -> Iterator[str]:
    """The lines of a trace: each folder, with what runs there one after the other."""
    for folder, calls in groupby(trace, key=lambda call: str(PurePath(call[0]).parent)):
        names = ", ".join(f"{PurePath(file).stem}: {function}" for file, function in calls)
        yield from wrap(names, first=f"    {folder:<{FOLDER}}", others=" " * (FOLDER + 4))


def wrap(names: str, first: str, others: str) -> list[str]:
    """Break a line between names only."""
    lines = textwrap.wrap(
        names.replace(": ", ":\0"),
        WIDTH,
        initial_indent=first,
        subsequent_indent=others,
        break_on_hyphens=False,
        break_long_words=False,
    )
    return [line.replace("\0", " ") for line in lines]


def section(title: str, trace: Trace) -> str:
    """A trace as Markdown."""
    lines = "\n".join(steps(trace))
    return f"### {title}\n\nIt passes through {len(trace)} files.\n\n{lines}\n\n"


def written(page: str) -> str:
    """The page, with new traces."""
    with ros_domain() as domain, TemporaryDirectory() as folder:
        traces = follow_gateway(domain, Path(folder))
    with ros_domain() as domain, TemporaryDirectory() as folder:
        traces |= follow_docking(domain, Path(folder))
    before, _, rest = page.partition(BEGIN)
    _, _, after = rest.partition(END)
    sections = "".join(section(title, usual(traces[kind])) for kind, title in TITLES.items())
    return f"{before}{BEGIN}\n{sections}{END}{after}"


if __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text()))
