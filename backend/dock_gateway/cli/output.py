"""The output of the programs that `up` runs: every line goes to a file, warnings and errors to the terminal, too."""

import fcntl
import logging
import re
import subprocess
import sys
import threading
from collections.abc import MutableMapping
from contextlib import suppress
from datetime import datetime
from logging.handlers import RotatingFileHandler
from pathlib import Path
from typing import IO, Self

import click

from dock_gateway.core.log_config import printable

# The start of a line that is no warning, of Python's and of ROS's loggers, for people and in JSON.
ROUTINE = re.compile(r'\[(DEBUG|INFO)\] |\{"time": "[^"]*", "level": "(debug|info)"')
# What makes ROS write lines like those of the gateway, and the time as these do.
ROS_FORMAT = "RCUTILS_CONSOLE_OUTPUT_FORMAT", "[{severity}] [{date_time_with_ms}] [{name}]: {message}"
# Bytes of one log file, and how many full ones are kept.
FILE_BYTES, FULL_FILES = 5_000_000, 2
# Characters of a line; what is longer becomes several.
LINE = 65_536
# Bytes that a program can write while this process is paused (Ctrl-Z): it must not wait for that.
PIPE_BYTES = 1_000_000
# Seconds for the last lines of programs that have ended.
LAST_LINES = 0.5


def use_one_format(environment: MutableMapping[str, str]) -> None:
    """Let the ROS nodes that this process starts write lines as the gateway does, unless the variable is set."""
    environment.setdefault(*ROS_FORMAT)


class _LogFile(RotatingFileHandler):
    """Tells its caller what goes wrong, such as a full disk."""

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: N802 - its name in `logging`
        """Raise the error that is being handled."""
        if (error := sys.exception()) is not None:
            raise error


class Output:
    """Where lines of programs go, a context manager. Usable from all threads.

    If the file cannot be written, the terminal gets all lines.

    Args:
        path: The log file. Full ones are renamed: `.1`, `.2`.
        verbose: Whether the terminal gets every line.
        file_bytes: The size of a full file.
    """

    def __init__(self, path: Path, *, verbose: bool = False, file_bytes: int = FILE_BYTES) -> None:
        self.path = path
        self._verbose = verbose
        self._file: _LogFile | None = None
        self._closed = False
        try:
            path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            self._file = _LogFile(path, maxBytes=file_bytes, backupCount=FULL_FILES, encoding="utf-8")
        except OSError as error:
            self._give_up(error)

    def __enter__(self) -> Self:
        """Return this output."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the file. What comes later is dropped."""
        self._closed = True
        if self._file is not None:
            self._file.close()

    def note(self, text: str) -> None:
        """Write a line of this process itself, which is a warning."""
        now = f"{datetime.now().astimezone():%Y-%m-%d %H:%M:%S.%f}"[:-3]
        self._store(f"[WARN] [{now}] [dock_gateway.cli.up]: {text}")
        click.echo(f"dock-gateway: {text}", err=True)

    def write(self, line: str) -> None:
        """Write a line of a program."""
        if self._closed:
            return
        stored = self._store(line)
        if self._verbose or not stored or not ROUTINE.match(line):
            click.echo(line, err=True)

    def follow(self, process: subprocess.Popen[str]) -> threading.Thread:
        """Write the lines of a process until it ends, in a thread that is returned.

        Args:
            process: Writes text to a pipe.
        """
        assert process.stdout is not None
        with suppress(OSError):  # the system limits what users may have
            fcntl.fcntl(process.stdout, fcntl.F_SETPIPE_SZ, PIPE_BYTES)
        reader = threading.Thread(target=self._read, args=(process.stdout,), daemon=True)
        reader.start()
        return reader

    def _read(self, stream: IO[str]) -> None:
        with stream:
            while line := stream.readline(LINE):
                self.write(line.rstrip("\n"))

    def _store(self, line: str) -> bool:
        if self._file is None:
            return False
        try:
            self._file.handle(logging.makeLogRecord({"msg": line}))
        except OSError as error:
            self._give_up(error)
            return False
        return True

    def _give_up(self, error: OSError) -> None:
        if self._file is not None:
            with suppress(OSError):
                self._file.close()
            self._file = None
        click.echo(printable(f"dock-gateway: no log is written to {self.path}: {error.strerror or error}"), err=True)
