"""One of our programs, which counts what cannot be noisy: transactions, synchronous writes, files, threads, services.

As a program: `python -m tests.support.counted FILE dock-gateway serve`. SIGUSR1 writes the counts so far to FILE.
"""

import os
import signal
import sys
import threading
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import orjson
from rclpy.client import Client

from dock_gateway.cli import main
from dock_gateway.ros.bridge import Bridge
from dock_gateway.storage.sqlite import SqliteDatabase

# Appended to by every thread.
seen: list[str] = []
FILES = {"open": "open", "os.rename": "rename", "os.remove": "remove", "os.mkdir": "make folder", "os.scandir": "list"}
writing = threading.local()


def name_of(function: Any) -> str:
    """The name of a function, or of that which a partial calls."""
    function = getattr(function, "func", function)
    return f"{function.__module__.rpartition('.')[2]}.{function.__qualname__}"


def count(owner: type, method: str, name: Callable[..., list[str]]) -> None:
    """Count the calls of a method, by names that are made of its arguments."""
    called = getattr(owner, method)

    def counted(*args: Any, **kwargs: Any) -> Any:
        seen.extend(name(*args, **kwargs))
        return called(*args, **kwargs)

    setattr(owner, method, counted)


def name_write(_: object, work: Any, *__: object, durable: bool = True) -> list[str]:
    return [f"transaction {name_of(work)}", *(["synchronous transaction"] if durable else [])]


def name_file(event: str, args: tuple[Any, ...]) -> None:
    if (what := FILES.get(event)) is None or getattr(writing, "now", False):
        return
    path = os.fsdecode(args[0]) if isinstance(args[0], str | bytes | os.PathLike) else ""
    if path and not path.startswith(("/proc/", "/sys/", "/dev/")):
        seen.append(f"{what} {Path(path).parent.name}/*{Path(path).suffix}")


def write(file: Path) -> None:
    writing.now = True
    file.with_suffix(".new").write_bytes(orjson.dumps(Counter(seen)))
    file.with_suffix(".new").replace(file)
    writing.now = False


if __name__ == "__main__":
    counts = Path(sys.argv[1])
    signal.signal(signal.SIGUSR1, lambda *_: write(counts))
    count(SqliteDatabase, "write", name_write)
    count(SqliteDatabase, "read", lambda _, work, *__: [f"read {name_of(work)}"])
    count(ThreadPoolExecutor, "submit", lambda self, *_, **__: [f"thread {self._thread_name_prefix}"])
    count(Bridge, "call", lambda _, function, *__, **___: [f"ROS thread {name_of(function)}"])
    count(Bridge, "to_loop", lambda _, function, *__: [f"event loop {name_of(function)}"])
    count(Client, "call_async", lambda self, _: [f"service {self.service_name}"])
    sys.addaudithook(name_file)
    sys.argv = sys.argv[2:]
    sys.exit(main())
