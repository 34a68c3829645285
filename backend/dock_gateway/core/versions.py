"""Versions of what people change: the entity tag of each, and the condition under which a request changes it."""

import hashlib
from dataclasses import dataclass

import orjson

from dock_gateway.core.errors import ChangedMeanwhile

EXISTING = "*"


@dataclass(frozen=True)
class Condition:
    """The state in which something must be for a request to change it.

    Attributes:
        match: The entity tags of which it must have one (`If-Match`); `*`: it must exist. None: any state will do.
        absent: Whether it must not exist (`If-None-Match: *`).
    """

    match: frozenset[str] | None = None
    absent: bool = False

    def require(self, etag: str | None) -> None:
        """Refuse the change, unless the condition is true.

        Args:
            etag: The present entity tag; None if there is no such thing.

        Raises:
            ChangedMeanwhile: It is not.
        """
        if self.absent and etag is not None:
            raise ChangedMeanwhile("it exists already, and nothing was changed; If-None-Match: * asks for a new one")
        if self.match is None:
            return
        if etag is None:
            raise ChangedMeanwhile("it was removed meanwhile, or was never there; nothing was changed")
        if EXISTING not in self.match and etag not in self.match:
            raise ChangedMeanwhile("it was changed meanwhile, and nothing was changed now: read it again, then decide")


UNCONDITIONAL = Condition()


def entity_tag(content: object) -> str:
    """Return the entity tag of a version, in quotes, as it is in the header `ETag`.

    Args:
        content: What makes the version: JSON, dataclasses or pydantic models.
    """
    text = orjson.dumps(content, default=vars, option=orjson.OPT_SORT_KEYS)
    return f'"{hashlib.sha256(text).hexdigest()[:32]}"'
