"""Programs as forks of a process that has imported them: one starts in 0.3 s, where a new Python takes ten times that.

Otherwise they run as from a shell: with the arguments, environment, output, signals and exit code of a process. Two
things differ: PYTHONPATH comes too late, and the interpreter ends without taking down its modules. Tests that are about
these, such as those of the exit, start a new Python.
"""

import contextlib
import faulthandler
import io
import multiprocessing
import os
import runpy
import signal
import subprocess
import sys
import threading
from importlib import import_module
from multiprocessing.connection import Connection

_context = multiprocessing.get_context("forkserver")
_context.set_forkserver_preload(["tests.support.programs"])


class Fork:
    """A program that runs, with what the suite uses of `subprocess.Popen`.

    Args:
        command: The name of one of our programs, or `-m` and a module; then the arguments.
        env: Its environment.
        typed: Its standard input.
    """

    def __init__(self, *command: str, env: dict[str, str], typed: str = "") -> None:
        reader, writer = _context.Pipe(duplex=False)
        self._process = _context.Process(target=_run, args=(command, env, writer, typed))
        self._process.start()
        writer.close()
        self.stdout = os.fdopen(os.dup(reader.fileno()), encoding="utf-8")
        reader.close()
        assert self._process.pid is not None
        self.pid = self._process.pid

    def poll(self) -> int | None:
        return self._process.exitcode

    def wait(self, timeout: float | None = None) -> int:
        self._process.join(timeout)
        if (code := self._process.exitcode) is None:
            raise subprocess.TimeoutExpired(str(self.pid), timeout or 0)
        return code

    def send_signal(self, number: signal.Signals) -> None:
        if self.poll() is None:
            with contextlib.suppress(ProcessLookupError):  # it has just ended
                os.kill(self.pid, number)

    def terminate(self) -> None:
        self.send_signal(signal.SIGTERM)

    def kill(self) -> None:
        self.send_signal(signal.SIGKILL)


def _end_with_parent() -> None:
    """A test run that is killed must not leave programs behind, which the next one on their ROS domain would meet."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os.kill(os.getpid(), signal.SIGKILL)


def _run(command: tuple[str, ...], env: dict[str, str], output: Connection, typed: str = "") -> None:
    """Become the program, in the new process."""
    for descriptor in (1, 2):
        os.dup2(output.fileno(), descriptor)
    output.close()
    sys.stdin = io.TextIOWrapper(io.BytesIO(typed.encode()))
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(line_buffering=True)
    faulthandler.enable()
    threading.Thread(target=_end_with_parent, daemon=True).start()
    os.environ.clear()
    os.environ.update(env)
    name, *arguments = command
    if name == "-m":
        sys.argv = arguments
        runpy.run_module(arguments[0], run_name="__main__", alter_sys=True)
    else:
        sys.argv = [name, *arguments]
        sys.exit(import_module("tests.support.programs").PROGRAMS[name]())
