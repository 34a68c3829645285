"""A line of JSON for each log record, whatever is in it and wherever it comes from."""

import json
import logging
import re
import subprocess
import sys
from collections.abc import Iterator
from datetime import datetime, timedelta
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.core.log_config import CONTROL, HumanFormatter, JsonFormatter
from dock_gateway.core.request import CURRENT, RequestContext


@pytest.fixture
def request_id() -> Iterator[str]:
    token = CURRENT.set(RequestContext("r-1", {}))
    yield "r-1"
    CURRENT.reset(token)


class Log:
    """A logger of its own."""

    def __init__(self) -> None:
        self.texts: list[str] = []
        handler = logging.Handler()
        handler.setFormatter(JsonFormatter())
        handler.emit = lambda record: self.texts.append(handler.format(record))  # type: ignore[method-assign]
        self.logger = logging.Logger("dock_gateway.some.part")
        self.logger.addHandler(handler)

    def line(self) -> dict[str, Any]:
        """The only line."""
        (text,) = self.texts
        assert "\n" not in text
        assert text.isascii()
        line: dict[str, Any] = json.loads(text)
        return line


@pytest.fixture
def log() -> Log:
    return Log()


def test_a_line(log: Log) -> None:
    log.logger.warning("a stop of %s is latched", "/robot1")
    line = log.line()
    assert line.pop("time").endswith("Z")
    assert line == {
        "level": "warning",
        "logger": "dock_gateway.some.part",
        "message": "a stop of /robot1 is latched",
    }


def test_a_line_for_people_is_one_line_whatever_is_in_it() -> None:
    text = "x\n[INFO] [forged]: a line\x1b[2K\r\u2028\té"
    record = logging.LogRecord("any", logging.INFO, "", 0, "got %s", (text,), None)
    line = HumanFormatter().format(record)
    assert line.endswith("[any]: got x\\n[INFO] [forged]: a line\\x1b[2K\\r\\u2028\té")
    assert line.startswith("[INFO] [2")


@given(st.text(st.characters(codec=None), max_size=60), st.text(max_size=60))
def test_no_text_makes_a_line_of_its_own(text: str, name: str) -> None:
    """Neither in a message nor in a traceback; and none of them reaches the terminal."""
    forged = f"{text}\n[ERROR] [2026-11-21 00:00:00,000] [forged]: {name}\x1b]0;x\x07\u202e"
    try:
        raise ValueError(forged)
    except ValueError:
        record = logging.LogRecord("any", logging.INFO, "", 0, "got %s", (forged,), sys.exc_info())
    written = HumanFormatter().format(record)
    assert len(re.findall(r"^\[[A-Z]+\] \[", written, re.MULTILINE)) == 1
    assert not CONTROL.search(written.replace("\n", ""))
    written.encode()
    record = logging.LogRecord("any", logging.INFO, "", 0, "got %s", (forged,), record.exc_info)
    (line,) = JsonFormatter().format(record).splitlines()
    message = json.loads(line)["message"]
    assert message.encode("utf-16", "surrogatepass") == f"got {forged}".encode("utf-16", "surrogatepass")
    assert line.isascii()


def test_a_traceback_has_its_own_lines() -> None:
    try:
        raise ValueError("a bug")
    except ValueError:
        record = logging.LogRecord("any", logging.ERROR, "", 0, "it broke", (), sys.exc_info())
    assert HumanFormatter().format(record).endswith("\nValueError: a bug")


def test_the_time_is_utc(log: Log) -> None:
    record = logging.LogRecord("any", logging.INFO, "", 0, "message", (), None)
    record.created = 1_767_268_800.25
    log.logger.handle(record)
    time = datetime.fromisoformat(log.line()["time"])
    assert time.isoformat() == "2026-01-01T12:00:00.250000+00:00"
    assert time.utcoffset() == timedelta(0)


def test_the_request_and_the_goal(log: Log, request_id: str) -> None:
    log.logger.info("goal %s", "g-1", extra={"goal_id": "g-1"})
    line = log.line()
    assert (line["request_id"], line["goal_id"]) == (request_id, "g-1")


def test_an_exception_is_a_field(log: Log) -> None:
    try:
        raise ValueError("ä\n\U0001f916")
    except ValueError:
        log.logger.exception("a command failed")
    line = log.line()
    assert line["message"] == "a command failed"
    assert line["exception"].startswith("Traceback")
    assert line["exception"].endswith("ValueError: ä\n\U0001f916")


@pytest.mark.parametrize("text", ['a"b\\c', "two\nlines\r\x1b[31m", "bytes \udcff of a path", "grün"])
def test_whatever_is_in_a_message(log: Log, text: str) -> None:
    log.logger.info("%s", text)
    assert log.line()["message"] == text


PROGRAM = """
import threading, warnings
from dock_gateway.core.log_config import configure_logs
from dock_gateway.settings import Settings
configure_logs(Settings(log_format="json"))
warnings.warn("old")
thread = threading.Thread(target=lambda: 1 / 0, name="worker")
thread.start()
thread.join()
raise RuntimeError("broken")
"""


def test_warnings_and_uncaught_exceptions_are_lines_too() -> None:
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=False)
    warning, thread, end = (json.loads(line) for line in done.stderr.splitlines())
    assert "UserWarning: old" in warning["message"]
    assert thread["message"] == "the thread worker ended with an error"
    assert "ZeroDivisionError" in thread["exception"]
    assert end["level"] == "critical"
    assert end["exception"].endswith("RuntimeError: broken")
    assert done.returncode == 1
    assert done.stdout == ""
