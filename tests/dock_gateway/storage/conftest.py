"""What the tests of the storage share."""

import pytest

from dock_gateway.storage import sqlite
from tests.support.waiting import PATIENCE


@pytest.fixture
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """A busy machine is no outage."""
    monkeypatch.setattr(sqlite, "BUSY_TIMEOUT", PATIENCE)
