"""A function in a child process."""

import os
import signal
import sys
import time

import pytest

from robot_io.children import run_apart


def crash() -> int:
    os.kill(os.getpid(), signal.SIGKILL)
    return 0


def test_the_exit_code_of_a_child() -> None:
    assert [run_apart(lambda code=code: code, 60) for code in (0, 1, 2)] == [0, 1, 2]  # type: ignore[misc]


def test_a_child_that_crashes_raises_or_takes_too_long_has_none(capfd: pytest.CaptureFixture[str]) -> None:
    assert run_apart(crash, 60) is None
    assert run_apart(lambda: sys.exit("left"), 60) is None
    began = time.monotonic()
    assert run_apart(lambda: time.sleep(60) or 0, 1) is None
    assert time.monotonic() - began < 30
    capfd.readouterr()
