"""Configures logging: lines for people, or JSON for a log collector (docs/logs.md)."""

import json
import logging
import re
import sys
import threading
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

from dock_gateway.core.log_limit import LogLimit
from dock_gateway.core.request import CURRENT

if TYPE_CHECKING:  # a stop does not wait for pydantic
    from dock_gateway.settings import Settings

log = logging.getLogger(__name__)

# What could begin another line, change a terminal or turn the direction of the text; surrogates cannot be written.
CONTROL = re.compile(r"[\x00-\x08\x0a-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")
# What a line of a traceback must not begin with, as it would look like the next record.
RECORD = re.compile(r"^(?=\[[A-Z]+\] \[)", re.MULTILINE)
HUMAN = "[%(levelname)s] [%(asctime)s] [%(name)s]: %(message)s"
# Libraries whose lines below a warning are of no interest, not even with `debug`.
NOISY = ("asyncio", "httpcore", "httpx2", "urllib3", "websockets")


def printable(text: str) -> str:
    """Return a text that stays in its line and leaves a terminal as it is: control characters are escaped."""
    return CONTROL.sub(lambda match: match[0].encode("unicode_escape").decode(), text)


class HumanFormatter(logging.Formatter):
    """Writes the message of a record in one line, whatever clients have sent. Tracebacks follow it."""

    default_msec_format = "%s.%03d"  # as ROS writes times

    def __init__(self) -> None:
        super().__init__(HUMAN)

    def formatMessage(self, record: logging.LogRecord) -> str:  # noqa: N802 - its name in `logging`
        """Return the line, with control characters escaped."""
        record.message = printable(record.message)
        return super().formatMessage(record)

    def formatException(self, ei: Any) -> str:  # noqa: N802 - its name in `logging`
        """Return the traceback. What clients have sent may be in the error's text, but makes no line of its own."""
        lines = super().formatException(ei).split("\n")
        return RECORD.sub(" ", "\n".join(map(printable, lines)))


class JsonFormatter(logging.Formatter):
    """Writes one JSON object per line, in ASCII. Fields without a value are left out."""

    def format(self, record: logging.LogRecord) -> str:
        """Return the line."""
        time = datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds")
        request = CURRENT.get()
        line = {
            "time": time.replace("+00:00", "Z"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": record.getMessage(),
            "request_id": request and request.request_id,
            "goal_id": getattr(record, "goal_id", None),
            "exception": self.formatException(record.exc_info) if record.exc_info else None,
            "stack": record.stack_info,
        }
        return json.dumps({name: value for name, value in line.items() if value is not None})


def configure_logs(settings: "Settings") -> None:
    """Configure the root logger, which every line goes to. With JSON, warnings and uncaught exceptions do, too."""
    logging.basicConfig()
    for handler in logging.getLogger().handlers:
        handler.setFormatter(JsonFormatter() if settings.log_format == "json" else HumanFormatter())
    for noisy in NOISY:
        logging.getLogger(noisy).setLevel(logging.WARNING)
    set_log_level(settings.log_level)
    if settings.log_format == "json":
        logging.captureWarnings(capture=True)
        sys.excepthook = lambda *error: log.critical("the gateway ended with an error", exc_info=error)
        threading.excepthook = _log_thread


def set_log_level(level: str) -> None:
    """Set the level of the root logger, also while the gateway runs. `debug` limits no lines.

    Args:
        level: As in the setting `log_level`.
    """
    root = logging.getLogger()
    root.setLevel(level.upper())
    debug = level == "debug"
    logging.getLogger("uvicorn").setLevel(logging.NOTSET if debug else logging.WARNING)
    for handler in root.handlers:
        limits = [each for each in handler.filters if isinstance(each, LogLimit)]
        if debug:
            for limit in limits:
                handler.removeFilter(limit)
        elif not limits:
            handler.addFilter(LogLimit())


def _log_thread(ended: threading.ExceptHookArgs) -> None:
    error = ended.exc_value
    log.error("the thread %s ended with an error", ended.thread and ended.thread.name, exc_info=error)
