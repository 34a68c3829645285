"""Work that takes long: on the event loop, in a thread or in a process of its own, depending on its size.

A thread that computes holds Python's lock, for as long as one call of a library takes: a stop then waits as if the work
were on the event loop. So a thread is only for what takes some milliseconds.
"""

import asyncio
import contextlib
import fcntl
import os
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import AsyncIterator, Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from threading import Lock, Timer
from typing import IO, ParamSpec, TypeVar

from dock_gateway.core.errors import TooManyRequests
from dock_gateway.core.request import slot

P = ParamSpec("P")
Result = TypeVar("Result")
Item = TypeVar("Item")

# Maximum bytes of a message that is processed on the event loop.
SMALL = 4096
# Maximum bytes of a message that is processed in a thread.
MEDIUM = 65_536
# Maximum bytes of a message that is processed at all: in the worker process.
MOST = 20_000_000
# Seconds that a piece of work may take in the process, whose start takes one or two.
WITHIN = 30.0
# Times as long as a client's message took in a thread: the pause before the next one, in which others work.
REST = 4
# Seconds that a loop over what a client has sent takes until others have their turn.
TURN = 0.001
# Large messages of clients that wait to be read.
MOST_WAITING = 32
# Bytes that a pipe to the process holds.
PIPE_BYTES = 1_000_000
# The niceness of the process above that of the gateway.
NICENESS = 5


class TooLarge(Exception):
    """A message is too large. The text is a sentence for users."""

    def __init__(self, size: int) -> None:
        super().__init__(f"a message of {size / 1e6:.1f} MB is too large: at most {MOST / 1e6:.0f} MB are read")


class Worker:
    """Calls functions in a process of its own, one after the other. The process starts with the first call.

    It ends with this process, also if that is killed: its input is a pipe.
    """

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._using = Lock()

    def call(self, function: Callable[P, Result], *args: P.args, **kwargs: P.kwargs) -> Result:
        """Return what a function returns there. Blocks; one call at a time.

        Args:
            function: One that a module has by its name.
            args: Its arguments, which are pickled.
            kwargs: More of them.

        Raises:
            RuntimeError: The function raised an error, whose text this has, or the process ended before it returned.
        """
        with self._using:
            process = self._process
            if process is None or process.poll() is not None:
                process = self._process = _start()
            assert process.stdin is not None
            assert process.stdout is not None
            deadline = Timer(WITHIN, process.kill)
            deadline.start()
            try:
                pickle.dump((function, args, kwargs), process.stdin, pickle.HIGHEST_PROTOCOL)
                process.stdin.flush()
                result, error = pickle.load(process.stdout)  # noqa: S301 - of our own process
            # ValueError: `kill` closes the pipes while this thread reads.
            except (EOFError, OSError, ValueError, pickle.UnpicklingError) as broken:
                self.kill()
                raise RuntimeError("the process for large messages has ended") from broken
            finally:
                deadline.cancel()
        if error is not None:
            raise RuntimeError(error)
        answer: Result = result
        return answer

    def kill(self) -> None:
        """End the process at once. It starts again with the next call."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.wait()
            for pipe in (process.stdin, process.stdout):
                with contextlib.suppress(OSError):
                    assert pipe is not None
                    pipe.close()


def _start() -> "subprocess.Popen[bytes]":
    process = subprocess.Popen(  # noqa: S603 - this module
        (sys.executable, "-m", __name__), stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    for pipe in (process.stdin, process.stdout):
        assert pipe is not None
        with contextlib.suppress(OSError):  # the system allows less
            fcntl.fcntl(pipe, fcntl.F_SETPIPE_SZ, PIPE_BYTES)
    return process


class Work:
    """Works on messages of any size, without blocking others."""

    def __init__(self) -> None:
        self._worker = Worker()
        self._thread = ThreadPoolExecutor(1, "work")
        self._process = ThreadPoolExecutor(1, "work-process")

    async def __call__(self, size: int, function: Callable[P, Result], *args: P.args, **kwargs: P.kwargs) -> Result:
        """Return what a function returns.

        Args:
            size: Bytes of the message that it works on.
            function: One that a module has by its name: it may run in another process.
            args: Its arguments; they can be pickled, and so can its result.
            kwargs: More of them.

        Raises:
            TooLarge: The message is too large.
            Exception: What the function raises; a RuntimeError, if that was in the process.
        """
        if size <= SMALL:
            return function(*args, **kwargs)
        loop = asyncio.get_running_loop()
        if size <= MEDIUM:
            return await loop.run_in_executor(self._thread, lambda: function(*args, **kwargs))
        if size > MOST:
            raise TooLarge(size)
        return await loop.run_in_executor(self._process, lambda: self._worker.call(function, *args, **kwargs))

    async def close(self) -> None:
        """End the process. What is being worked on fails."""
        for executor in (self._thread, self._process):
            executor.shutdown(wait=False, cancel_futures=True)
        self._worker.kill()


class Lane:
    """A thread for what clients send: one after the other, with pauses, in which others work."""

    def __init__(self) -> None:
        self._thread: ThreadPoolExecutor | None = None
        self._waiting = 0
        self._rest_until = 0.0

    async def __call__(self, function: Callable[P, Result], *args: P.args, **kwargs: P.kwargs) -> Result:
        """Return what a function returns. It is Python code, which lets other threads run at any time.

        Raises:
            TooManyRequests: Too many of the user wait, or of all users together; or too many are waiting, with those
                of the gateway itself (`too_much_input`).
            Exception: What the function raises.
        """
        if self._waiting >= MOST_WAITING:
            raise TooManyRequests("too many large messages wait to be read: try again", code="too_much_input")
        thread = self._thread = self._thread or ThreadPoolExecutor(1, "lane")

        def run() -> Result:
            if (rest := self._rest_until - time.monotonic()) > 0:
                time.sleep(rest)
            began = time.thread_time()
            try:
                return function(*args, **kwargs)
            finally:
                self._rest_until = time.monotonic() + REST * (time.thread_time() - began)

        self._waiting += 1
        try:
            with slot("large messages"):
                return await asyncio.get_running_loop().run_in_executor(thread, run)
        finally:
            self._waiting -= 1

    async def close(self) -> None:
        """Forget what waits."""
        thread, self._thread = self._thread, None
        if thread is not None:
            thread.shutdown(wait=False, cancel_futures=True)


in_turn = Lane()


async def in_turns(items: Iterable[Item]) -> AsyncIterator[Item]:
    """Yield items, and give way each time that what is done with them has taken a millisecond."""
    since = time.perf_counter()
    for item in items:
        if time.perf_counter() - since > TURN:
            await asyncio.sleep(0)
            since = time.perf_counter()
        yield item


def serve(requests: IO[bytes], answers: IO[bytes]) -> None:
    """Work for another process until it ends."""
    while True:
        try:
            function, args, kwargs = pickle.load(requests)  # noqa: S301 - of our own process
        except EOFError:
            return
        result, error = None, None
        try:
            result = function(*args, **kwargs)
        except Exception as raised:  # noqa: BLE001 - whatever the bytes of others bring about
            error = str(raised)
        pickle.dump((result, error), answers, pickle.HIGHEST_PROTOCOL)
        answers.flush()


def main() -> None:
    """Run as the process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the gateway
    os.nice(NICENESS)
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # what a library prints is no answer
    serve(sys.stdin.buffer, answers)


if __name__ == "__main__":
    main()
