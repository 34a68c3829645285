"""A wait for signals ends whichever thread the kernel hands them to."""

import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

SIGNALS = [signal.SIGTERM, signal.SIGINT, signal.SIGHUP]

WAITS = """
import signal, sys, threading, time
from docking.ros.process import StopSignals
if "nohup" in sys.argv:
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
signals = StopSignals()
# Another thread is the only one left to take a signal, as after SIGSTOP.
threading.Thread(target=time.sleep, args=(600,), daemon=True).start()
signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM, signal.SIGHUP})
print("waiting", flush=True)
if "wake" in sys.argv:
    threading.Timer(0.1, signals.wake).start()
print("woken by", signals.wait(), flush=True)
"""


@contextmanager
def waiting(*arguments: str) -> Iterator[subprocess.Popen[str]]:
    """A process that waits, and is killed where that takes too long."""
    with subprocess.Popen([sys.executable, "-c", WAITS, *arguments], stdout=subprocess.PIPE, text=True) as process:
        watchdog = threading.Timer(30, process.kill)
        watchdog.start()
        assert process.stdout is not None
        assert process.stdout.readline() == "waiting\n"
        yield process
        assert process.wait() == 0
        watchdog.cancel()


def says(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None
    return process.stdout.readline()


@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_that_another_thread_takes_ends_the_wait(number: signal.Signals) -> None:
    with waiting() as process:
        process.send_signal(number)
        assert says(process) == "woken by 1\n"


def test_another_thread_ends_the_wait() -> None:
    with waiting("wake") as process:
        assert says(process) == "woken by 0\n"


def test_the_end_of_the_terminal_stays_ignored_under_nohup() -> None:
    with waiting("nohup") as process:
        process.send_signal(signal.SIGHUP)
        process.send_signal(signal.SIGTERM)
        assert says(process) == "woken by 1\n"
