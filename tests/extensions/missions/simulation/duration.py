"""For how long something has been so that should not last."""


class Duration:
    """Counts seconds by name, from the first look at which it is so.

    Args:
        longest: Seconds for which it may be so.
    """

    def __init__(self, longest: float) -> None:
        self._longest = longest
        self._seconds: dict[str, float] = {}

    def keep(self, names: set[str]) -> None:
        """Forget all others."""
        self._seconds = {name: seconds for name, seconds in self._seconds.items() if name in names}

    def exceeds(self, name: str, passed: float, *, holds: bool) -> bool:
        """Return whether it has been so for too long, which is said once.

        Args:
            name: Of what it is so.
            passed: Seconds since the last look.
            holds: Whether it is so.
        """
        seconds = self._seconds.get(name, -passed) + passed if holds else 0.0
        self._seconds[name] = 0.0 if seconds > self._longest else seconds
        return seconds > self._longest
