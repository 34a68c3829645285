"""Runs one of our programs, and writes which functions a request, a message or a control step passes through.

    python -m scripts.follow OUTPUT PROGRAM [ARGUMENT…]

A trace ends with what it sends to DDS or to a socket (`GOALS`). It follows the work into the tasks, callbacks and
threads that it starts, as they inherit its context. What another task does for it is not followed: the trace names the
function that hands the work over. Log lines are left out.
"""

import inspect
import json
import signal
import sys
import threading
from collections import defaultdict
from collections.abc import Callable
from concurrent.futures import Executor, ThreadPoolExecutor
from contextvars import ContextVar, copy_context
from dataclasses import dataclass, field
from importlib.metadata import entry_points
from pathlib import Path
from types import FrameType
from typing import Any

BACKEND = f"{Path(__file__).parents[1] / 'backend'}/"
DOCK, STOP, FEEDBACK, STEP = "dock", "stop", "feedback", "step"
# What a trace has sent when it is complete: the last part of the names of topics and services, or `socket`.
GOALS = {
    DOCK: {"send_goal"},
    STOP: {"cmd_vel", "stop_latched", "cancel_goal"},
    FEEDBACK: {"socket"},
    STEP: {"cmd_vel"},
}
COROUTINES = inspect.CO_GENERATOR | inspect.CO_COROUTINE | inspect.CO_ASYNC_GENERATOR
PATHS = {"/dock": DOCK, "/stop": STOP}


@dataclass
class Trace:
    """The files that were entered so far, each with the first function.

    Attributes:
        missing: What is not sent yet.
    """

    missing: set[str]
    files: dict[str, str] = field(default_factory=dict)

    def enter(self, file: str, function: str) -> None:
        """Note a call, unless the trace is complete."""
        if self.missing:
            self.files.setdefault(file, function)


traces: defaultdict[str, list[Trace]] = defaultdict(list)
current: ContextVar[Trace | None] = ContextVar("current", default=None)
COMPLETE = Trace(set())
# Of each thread: `callback`, ROS's one that is being traced, and `logging`, the call that writes a log line.
frames = threading.local()


def follow(frame: FrameType, event: str, _argument: object) -> None:
    """Note a call, as a profile function."""
    if event == "return":
        _return(frame)
    if event != "call" or getattr(frames, "logging", None):
        return
    code = frame.f_code
    trace = current.get()
    if code.co_filename.startswith(BACKEND):
        if trace is None:
            trace = _begin(frame)
        if trace is not None and not _resumes(frame):
            trace.enter(code.co_filename.removeprefix(BACKEND), code.co_qualname)
    elif trace is not None:
        _call_library(frame, trace)


def _return(frame: FrameType) -> None:
    if frame is getattr(frames, "callback", None):
        frames.callback = None
        current.set(None)
    elif frame is getattr(frames, "logging", None):
        frames.logging = None


def _begin(frame: FrameType) -> Trace | None:
    """Begin a trace, if one begins with this call of ours."""
    kind = _begins(frame)
    if kind is None:
        return None
    trace = Trace(set(GOALS[kind]))
    traces[kind].append(trace)
    current.set(trace)
    return trace


def _resumes(frame: FrameType) -> bool:
    """Whether a call only resumes a coroutine: the argument of RESUME says so."""
    code = frame.f_code
    return bool(code.co_flags & COROUTINES) and code.co_code[frame.f_lasti + 1] & 3 != 0


def _begins(frame: FrameType) -> str | None:
    """Return which trace begins with a call of ours, if one does."""
    caller = frame.f_back
    if caller is None:
        return None
    file, name = caller.f_code.co_filename, caller.f_code.co_name
    if name == "run_endpoint_function":
        return PATHS.get(caller.f_locals["dependant"].path)
    kind = None
    if "/rclpy/" in file and frame.f_code.co_filename.startswith(f"{BACKEND}docking/"):
        kind = STEP
    elif any(_topic(value).endswith("_action/feedback") for value in frame.f_locals.values()):
        kind = FEEDBACK
    if kind is not None:
        frames.callback = frame
    return kind


def _topic(value: object) -> str:
    """Return the topic of a subscription, and an empty text for any other value."""
    return str(getattr(value, "topic_name", "")) if type(value).__name__ == "Subscription" else ""


def _call_library(frame: FrameType, trace: Trace) -> None:
    """Note what a call of a library sends. A request to ROS ends the trace of its task: its answer is not followed."""
    file, name = frame.f_code.co_filename, frame.f_code.co_name
    if "/rclpy/" in file and name == "publish":
        trace.missing.discard(_last(frame.f_locals["self"].topic_name))
    elif "/rclpy/" in file and name == "call_async":
        trace.missing.discard(_last(frame.f_locals["self"].service_name))
        current.set(COMPLETE)
    elif "/asyncio/" in file and name == "write":
        trace.missing.discard("socket")
    elif file.endswith("/logging/__init__.py") and name == "handle":
        frames.logging = frame


def _last(name: str) -> str:
    return name.rpartition("/")[2]


def _submit(submit: Callable[..., Any]) -> Callable[..., Any]:
    """Let what an executor runs inherit the context."""

    def submitted(self: Executor, function: Callable[..., Any], /, *args: Any, **options: Any) -> Any:
        return submit(self, copy_context().run, function, *args, **options)

    return submitted


def main() -> None:
    """Run the program; at SIGUSR1, write the complete traces."""
    output, program, *arguments = sys.argv[1:]

    def write(*_: object) -> None:
        sys.setprofile(None)
        complete = {
            kind: [list(trace.files.items()) for trace in found if not trace.missing] for kind, found in traces.items()
        }
        Path(output).write_text(json.dumps(complete))
        print("traces written", flush=True)

    signal.signal(signal.SIGUSR1, write)
    sys.modules["uvloop"] = None  # type: ignore[assignment] - its calls are not seen
    ThreadPoolExecutor.submit = _submit(ThreadPoolExecutor.submit)  # type: ignore[method-assign]
    sys.argv = [program, *arguments]
    (entry,) = entry_points(group="console_scripts", name=program)
    function = entry.load()
    threading.setprofile(follow)
    sys.setprofile(follow)
    sys.exit(function())


if __name__ == "__main__":
    main()
