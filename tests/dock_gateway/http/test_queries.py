"""Times in queries."""

import pytest

from dock_gateway.core.errors import InvalidField
from dock_gateway.http.queries import EARLIEST, LATEST, require_span


def test_a_span_ends_after_its_start() -> None:
    for since, until in ((EARLIEST, LATEST), (None, EARLIEST), (LATEST, None), (None, None)):
        require_span(since, until)
    for since in (LATEST, EARLIEST):
        with pytest.raises(InvalidField) as refused:
            require_span(since, EARLIEST)
        (error,) = refused.value.extra["errors"]
        assert (error["in"], error["path"], error["expected"]) == ("query", "since", "a time before `until`")
