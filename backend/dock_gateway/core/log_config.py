"""Where log lines go, and how they look: for people, or as JSON for a log collector (docs/logs.md)."""

import json
import logging
import sys
import threading
from datetime import UTC, datetime

from dock_gateway.core.log_limit import LogLimit
from dock_gateway.core.request import CURRENT
from dock_gateway.settings import Settings

log = logging.getLogger(__name__)

HUMAN = "[%(levelname)s] [%(asctime)s] [%(name)s]: %(message)s"
# Libraries whose lines below a warning are of no interest, not even with `debug`.
NOISY = ("asyncio", "httpcore", "httpx2", "urllib3", "websockets")


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


def configure_logs(settings: Settings) -> None:
    """Configure the root logger, which every line goes to. With JSON, warnings and uncaught exceptions do, too."""
    debug = settings.log_level == "debug"
    logging.basicConfig(level=settings.log_level.upper(), format=HUMAN)
    for handler in logging.getLogger().handlers:
        if settings.log_format == "json":
            handler.setFormatter(JsonFormatter())
        if not debug:
            handler.addFilter(LogLimit())
    for noisy in NOISY:
        logging.getLogger(noisy).setLevel(logging.WARNING)
    if not debug:
        logging.getLogger("uvicorn").setLevel(logging.WARNING)
    if settings.log_format == "json":
        logging.captureWarnings(capture=True)
        sys.excepthook = lambda *error: log.critical("the gateway ended with an error", exc_info=error)
        threading.excepthook = _log_thread


def _log_thread(ended: threading.ExceptHookArgs) -> None:
    error = ended.exc_value
    log.error("the thread %s ended with an error", ended.thread and ended.thread.name, exc_info=error)
