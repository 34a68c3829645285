"""Processes that end with the one that started them."""

import ctypes
import signal

PR_SET_PDEATHSIG = 1
# Simulated robots at most, each of which is a process.
MAX_ROBOTS = 20


def end_with_parent() -> None:
    """Let the kernel send SIGTERM to this process when its parent has ended, even if that was killed."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)
