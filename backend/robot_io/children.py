"""Processes that end with the one that started them."""

import ctypes
import os
import signal
import sys
import traceback
from collections.abc import Callable

PR_SET_PDEATHSIG = 1
# The maximum number of simulated robots: each is a process.
MAX_ROBOTS = 20


def end_with_parent() -> None:
    """Let the kernel send SIGTERM to this process when its parent has ended, even if that was killed."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)


def run_apart(body: Callable[[], int], within: int) -> int | None:
    """Run a function in a child process: whatever becomes of that, this process goes on.

    Args:
        body: Returns the exit code of the child.
        within: Seconds after which the child is ended.

    Returns:
        The exit code; None if the child crashed, or was ended.
    """
    if (child := os.fork()) == 0:
        code = 1
        try:
            end_with_parent()
            signal.alarm(within)
            code = body()
        except BaseException:  # noqa: BLE001 - the child never returns
            traceback.print_exc()
            os.abort()
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(code)
    _, status = os.waitpid(child, 0)
    return os.WEXITSTATUS(status) if os.WIFEXITED(status) else None
