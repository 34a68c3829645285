"""A disk that is full, read-only or locked, and a history file that is deleted or damaged, while goals are sent.

Whatever happens, no goal that was accepted is lost (but for what a deleted or damaged file held of goals that had
ended), refusals are the documented ones, streams go on, a stop works, `/readyz` tells the truth, and the gateway
recovers by itself.
"""

import os
import random
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from tests.chaos.disk import FAULTS, Disk, Trial, really_full, status
from tests.chaos.fleet import Fleet, wait_for_action
from tests.chaos.load import FINAL, Load
from tests.chaos.report import report
from tests.support.probe import Findings, probing, quantile
from tests.support.processes import Process
from tests.support.waiting import wait_until

pytestmark = [pytest.mark.ros, pytest.mark.timeout(3600)]

ROUNDS = int(os.environ.get("CHAOS_DISK_ROUNDS", "1"))
CONFINED = (sys.executable, "-m", "tests.support.confined")
# What a goal may be answered with meanwhile; `stopped` and `stop_latched` as stops are asked for all the time.
ANSWERS = {"200", "202", "history_unavailable", "stopped", "stop_latched", "broken off", "action_not_found"}
ANSWERS |= {"action_server_unavailable", "action_server_unresponsive", "action_server_timeout"}  # just after a start
KEPT = 1.0  # seconds that a fault lasts, at least


def withstand(trial: Trial, name: str, fault: Callable[[Trial], Any]) -> None:
    """Let something happen to the disk for a while, under load and watched."""
    trial.wait_for_new_goals()
    before, accepted = trial.answers(), len(trial.load.accepted)
    with fault(trial):
        if not takes_nothing(name):  # before anything is stopped: a key that a stop used waits for the database
            trial.wait_for_new_goals()
        with probing(trial.gateway) as findings:
            time.sleep(KEPT)
            wait_until(lambda: findings.complete, "an answer to each probe")
            if takes_nothing(name):  # not at once where the gateway has just been started and looks for the action
                wait_until(lambda: trial.answers()["history_unavailable"] > before["history_unavailable"], "a refusal")
            wait_until(lambda: tells(trial.history, name), f"/readyz tells of: {name}")
            state = trial.history
            alerts = {alert["kind"] for alert in trial.gateway.http.get("/alerts").json()["alerts"]}
            refused = (trial.answers() - before)["history_unavailable"]
        stop = trial.gateway.http.post("/stop", json={"by": "the test"}).raise_for_status().json()
        trial.gateway.http.delete("/stop").raise_for_status()
        meanwhile = len(trial.load.accepted) - accepted
    began = time.monotonic()
    with trial.load.paused():  # where the database of a busy machine is slow, there is always a new goal in the spool
        wait_until(lambda: healthy(trial), f"the gateway recovers from: {name}")
    recovered = time.monotonic() - began
    trial.wait_for_new_goals()
    trial.figures[name] = (
        f"{meanwhile} goals accepted, {refused} refused; a stop took {1000 * quantile(findings.stop, 0.5):.0f} ms, p99 "
        f"{1000 * quantile(findings.stop, 0.99):.0f} ms; the stream paused for {1000 * max(findings.gaps):.0f} ms at "
        f"most; recovered after {recovered:.1f} s; "
        f"`last_error`: {(state['last_error'] or '').replace(str(trial.disk.at), '')[:90]}"
    )
    check(trial, name, Seen(findings, state, alerts, refused, stop))
    assert trial.missing() == [], name


def takes_nothing(name: str) -> bool:
    """Whether neither database nor spool takes a goal."""
    return name in ("full", "really full", "read-only")


def tells(state: dict[str, Any], name: str) -> bool:
    """Whether `/readyz` says what has happened."""
    error: str = state["last_error"] or ""
    if name in ("deleted", "damaged", "damaged at the start"):
        return name.partition(" ")[0] in error
    return not state["database_reachable"] and ("locked" if name == "locked" else "") in error


def healthy(trial: Trial) -> bool:
    state = trial.history
    return bool(state["database_reachable"]) and not state["spooled"]


@dataclass
class Seen:
    """What was seen while something happened to the disk: by probes, in `/readyz`, of alerts, goals and a stop."""

    findings: Findings
    state: dict[str, Any]
    alerts: set[str]
    refused: int
    stop: dict[str, Any]


def check(trial: Trial, name: str, seen: Seen) -> None:
    findings, state, stop = seen.findings, seen.state, seen.stop
    assert findings.errors == [], (name, findings)
    assert max(findings.stop) < 5, (name, findings)
    assert max(findings.gaps) < 5, (name, findings)
    assert stop["stop"]["latched"], (name, stop)
    if takes_nothing(name):
        assert seen.refused > 0, name
        assert stop["warning"]["code"] == "stop_not_persisted", (name, stop)
    elif name == "locked":
        assert state["spooled"], (name, state)
    else:
        assert "history_lost" in seen.alerts, (name, seen.alerts)
    assert set(trial.answers()) <= ANSWERS, (name, trial.answers())


def check_goals(trial: Trial, title: str) -> None:
    """Once nothing is sent any more: what was accepted is there after a restart, ended, and was executed once."""
    trial.load.stop_sending()
    expected = {n: goal_id for n, goal_id in trial.load.accepted.items() if goal_id not in trial.gone}
    for goal_id in expected.values():
        wait_until(lambda goal_id=goal_id: status(trial, goal_id) in FINAL, f"goal {goal_id} ends")
    trial.restart(lambda: None)
    wait_until(lambda: healthy(trial), "the history is there after a restart")
    missing = list(expected.values())

    def found() -> bool:
        """An end that was not stored yet when the gateway was killed comes from the action server again."""
        missing[:] = [goal_id for goal_id in missing if status(trial, goal_id) not in FINAL]
        return not missing

    with suppress(AssertionError):
        wait_until(found, "every goal")
    twice = [number for number, count in trial.began.items() if count > 1 and number not in trial.unsure]
    report(
        title,
        {
            **trial.figures,
            "goals accepted": len(trial.load.accepted),
            "goals missing after a restart": len(missing),
            "goals that went with a deleted or damaged file": len(trial.gone & set(trial.load.accepted.values())),
            "goals executed twice": len(twice),
            "answers": dict(trial.answers()),
        },
    )
    assert missing == []
    assert twice == []
    trial.load.reader.finish()


@contextmanager
def trial_on(domain: int, disk: Disk, executed: Path, *prefix: str) -> Iterator[Trial]:
    with Fleet(domain, 1, *prefix, **disk.settings) as fleet:
        wait_for_action(fleet)
        with Load(fleet.url) as load:
            yield Trial(disk, fleet, load, executed)


def test_whatever_happens_to_the_disk(domain: int, executed: Path, tmp_path: Path) -> None:
    folder = tmp_path / "kept"
    folder.mkdir()
    with trial_on(domain, Disk(folder), executed, *CONFINED) as trial:
        for turn in range(ROUNDS):
            faults = list(FAULTS.items())
            if turn:
                random.shuffle(faults)
            for name, fault in faults:
                withstand(trial, name, fault)
                for path in trial.disk.damaged_files:
                    path.rename(tmp_path / path.name)
        check_goals(trial, f"A disk that fails in every way, {ROUNDS} times")


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[tuple[Disk, tuple[str, ...]]]:
    """A disk of 3 MB for each round, in a namespace that needs no root, and how to run a command there."""
    folder = tmp_path / "small"
    folder.mkdir()
    mount = f'mount -t tmpfs -o size={3 * ROUNDS}m tmpfs "$0" && echo mounted && exec sleep 3600'
    command = ("unshare", "--mount", "--map-root-user", "sh", "-c", mount, str(folder))
    try:
        process = Process(*command, env=dict(os.environ))
    except FileNotFoundError:
        pytest.skip("A FULL DISK IS TRIED BY LIMITS ALONE: there is no `unshare`")
    with process:
        try:
            process.wait_for("mounted")
        except AssertionError as error:
            pytest.skip(f"A FULL DISK IS TRIED BY LIMITS ALONE: no file system can be mounted here: {error}")
        enter = ("nsenter", "--preserve-credentials", "--user", "--mount", f"--target={process.pid}", "--")
        yield Disk(folder, Path(f"/proc/{process.pid}/root{folder}")), enter


def test_a_disk_without_a_block_left(domain: int, executed: Path, small_disk: tuple[Disk, tuple[str, ...]]) -> None:
    disk, enter = small_disk
    with trial_on(domain, disk, executed, *enter) as trial:
        for _ in range(ROUNDS):
            withstand(trial, "really full", really_full)
        check_goals(trial, f"A disk without a block left, {ROUNDS} times")
