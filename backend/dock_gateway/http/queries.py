"""Query parameters of several features: times, and ids of events."""

import re
from datetime import UTC, datetime
from typing import Annotated

from fastapi import Query
from pydantic import AfterValidator, AwareDatetime, BeforeValidator

from dock_gateway.core.errors import FieldError, InvalidField

# The range of ROS times, which are 64-bit nanoseconds.
EARLIEST, LATEST = datetime(1970, 1, 1, tzinfo=UTC), datetime(2262, 1, 1, tzinfo=UTC)
RFC_3339 = re.compile(
    r"(?:19[7-9][0-9]|2[01][0-9]{2}|22[0-5][0-9]|226[01])-(?:0[1-9]|1[0-2])-(?:0[1-9]|[12][0-9]|3[01])"
    r"[Tt](?:[01][0-9]|2[0-3]):[0-5][0-9]:[0-5][0-9](?:\.[0-9]+)?(?:[Zz]|[+-](?:[01][0-9]|2[0-3]):[0-5][0-9])"
)


def _as_documented(text: object) -> object:
    """Refuse times out of range, and the numbers and shorter forms that pydantic also accepts."""
    if not isinstance(text, str) or not RFC_3339.fullmatch(text):
        raise ValueError("an RFC 3339 time from 1970 to 2261, such as 2026-11-21T03:32:40Z")
    return text


def _in_utc(time: datetime) -> datetime:
    """Return the time in UTC, clamped to the supported range."""
    return min(max(time.astimezone(UTC), EARLIEST), LATEST)


Time = Annotated[AwareDatetime, BeforeValidator(_as_documented), AfterValidator(_in_utc)]
TIME_PATTERN = {"pattern": f"^{RFC_3339.pattern}$"}
SinceQuery = Annotated[
    Time | None, Query(description="At this time or later, RFC 3339", json_schema_extra=TIME_PATTERN)
]
UntilQuery = Annotated[Time | None, Query(description="Before this time, RFC 3339", json_schema_extra=TIME_PATTERN)]


def require_span(since: datetime | None, until: datetime | None) -> None:
    """Check that a span ends after its start; one without a start or an end does.

    Raises:
        InvalidField: It does not.
    """
    if since is not None and until is not None and since >= until:
        raise InvalidField([FieldError("since", "a time before `until`", f"got {since.isoformat()}", "query")])


EVENT_ID = re.compile(r"[0-9]{20}-[A-Za-z0-9_/-]{1,300}")
