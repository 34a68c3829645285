"""kill -9 right after a goal was kept: it is there."""

import signal
import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path

import pytest

from tests.dock_gateway.storage.conftest import Outage
from tests.support.history import open_at, written
from tests.support.waiting import until


def keep_and_die(url: str, folder: Path, last: int) -> str:
    """Have a process keep goals, and kill it in the moment when it says that `last` is kept."""
    command = [sys.executable, "-u", "-m", "tests.support.history", "keep", url, str(folder), "0", str(last + 20)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if line.startswith(f"kept {last} "):
                process.send_signal(signal.SIGKILL)
                return line
    raise AssertionError("the process ended before")


@pytest.mark.parametrize("answering", [True, False], ids=["answering", "not answering"])
async def test_a_goal_that_was_kept_is_there(outage: tuple[str, Outage], tmp_path: Path, answering: bool) -> None:
    url, not_answering = outage
    async with open_at(url, tmp_path):
        pass
    for last in (0, 7):
        with nullcontext() if answering else not_answering():
            said = keep_and_die(url, tmp_path, last)
        assert answering or not said.endswith("spooled 0\n"), said
        async with open_at(url, tmp_path) as history:
            await until(lambda: history.stats().database_reachable)
            for number in range(last + 1):
                goal = await history.by_key(f"key-{number}")
                assert goal is not None
                assert goal.goal_id == f"goal-{number:04d}"
            await written(history)
    assert list((tmp_path / "spool").glob("*")) == []
