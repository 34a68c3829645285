"""The result of one check."""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any


class Level(StrEnum):
    """The outcome of a check: with an error, the gateway does not start or a robot does not dock."""

    OK = "ok"
    WARNING = "warning"
    ERROR = "error"


@dataclass(frozen=True)
class Check:
    """The result of one check.

    Attributes:
        name: What was checked, such as `domain`.
        level: How it went.
        text: What was found, and what to do about it.
        settings: Lines of an environment file that do it.
    """

    name: str
    level: Level
    text: str
    settings: list[str] = field(default_factory=list)

    def document(self) -> dict[str, Any]:
        """Return it as `--json` shows it."""
        return {"name": self.name, "level": self.level, "text": self.text, "settings": self.settings}


def judge(name: str, fault: str | None, found: str, level: Level = Level.ERROR) -> Check:
    """Return a check that is an error if there is a fault, and says what was found if not.

    Args:
        name: What was checked.
        fault: The fault and what to do about it; None: none.
        found: What was found.
        level: That of a fault.
    """
    return Check(name, Level.OK, found) if fault is None else Check(name, level, fault)
