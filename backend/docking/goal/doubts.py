"""Collects what seemed wrong while a goal ran, for its final error and its report."""

MOST = 6
"""Doubts that a final error names; of more it names the first ones and the number of the others."""
LONGEST = 240
"""Characters of one doubt; a longer one is cut."""


class Doubts:
    """A record of what seemed wrong on the way: one sentence for each kind, so that it stays short.

    A goal has one, as `Goal.doubts`; the plans that see the dock make it, and their behaviors reach it as `aim.doubts`.
    """

    def __init__(self) -> None:
        """Begin without a doubt."""
        self._sentences: dict[str, str] = {}
        self._times: dict[str, int] = {}

    def note(self, kind: str, sentence: str) -> None:
        """Note a state. It may be called at each step: a later sentence replaces an earlier one of its kind.

        Args:
            kind: Identifies the doubt, such as `other_marker`; users do not see it.
            sentence: For users, without a full stop at its end; with figures and their units.
        """
        self._sentences[kind] = sentence
        self._times.setdefault(kind, 1)

    def count(self, kind: str, sentence: str) -> None:
        """Note an event: the last sentence of its kind stays, with the number of events."""
        self._sentences[kind] = sentence
        self._times[kind] = self._times.get(kind, 0) + 1

    def sentences(self, error: str = "") -> tuple[str, ...]:
        """Return the doubts in the order in which they first came up.

        Args:
            error: What this says already is left out.
        """
        left = [(kind, sentence) for kind, sentence in self._sentences.items() if sentence not in error]
        named = [_short(sentence) + _times(self._times[kind]) for kind, sentence in left[:MOST]]
        return (*named, f"{len(left) - MOST} more") if len(left) > MOST else tuple(named)

    def explain(self, error: str) -> str:
        """Return an error with the doubts behind it."""
        doubts = self.sentences(error)
        return f"{error}. Noted on the way: {'; '.join(doubts)}" if doubts else error


def _short(sentence: str) -> str:
    return sentence if len(sentence) <= LONGEST else f"{sentence[: LONGEST - 1]}…"


def _times(times: int) -> str:
    return f" ({times} times)" if times > 1 else ""
