"""The settings that let clients reach the ROS graph past goals and the latch: lists of patterns, empty by default."""

from collections.abc import Iterable

from dock_gateway.core.errors import NotAllowed
from dock_gateway.core.patterns import expression, match_any


class AllowList:
    """One such setting.

    Args:
        setting: Its name, such as `allow_services`.
        patterns: Its value.
        refused: What it allows, such as `the gateway calls no service`.
    """

    def __init__(self, setting: str, patterns: Iterable[str], refused: str) -> None:
        self._setting = setting
        self._refused = refused
        self.replace(patterns)

    def replace(self, patterns: Iterable[str]) -> None:
        """Take another value, from now on."""
        listed = [*patterns]
        self._expression = match_any(map(expression, listed)) if listed else None

    def __bool__(self) -> bool:
        """Whether it allows anything."""
        return self._expression is not None

    def covers(self, name: str) -> bool:
        """Return whether it names something."""
        return self._expression is not None and self._expression.fullmatch(name) is not None

    def require(self, name: str) -> None:
        """Refuse what it does not name.

        Raises:
            NotAllowed: `not_allowed`; the sentence and `settings` say what would allow it.
        """
        if not self.covers(name):
            option = f"--{self._setting.replace('_', '-')} '{name}'"
            raise NotAllowed(
                f"{self._refused} {name[:200]}: start it with {option} to allow that",
                code="not_allowed",
                settings=[f'{self._setting} = ["{name}"]'],
            )
