"""What the tests of the storage share."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

import pytest

from dock_gateway.storage import sqlite
from tests.support.history import locked
from tests.support.postgresql import PostgreSQL
from tests.support.waiting import PATIENCE


@pytest.fixture
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """A busy machine is no outage."""
    monkeypatch.setattr(sqlite, "BUSY_TIMEOUT", PATIENCE)


Outage = Callable[[], AbstractContextManager[None]]


@contextmanager
def stopped(server: PostgreSQL) -> Iterator[None]:
    server.stop()
    try:
        yield
    finally:
        server.start()


@pytest.fixture(params=["sqlite locked", "postgresql stopped", "postgresql frozen"])
def outage(request: pytest.FixtureRequest) -> tuple[str, Outage]:
    """A database, and how to have it not answer."""
    kind: str = request.param
    if kind == "sqlite locked":
        url: str = request.getfixturevalue("sqlite_url")
        return url, lambda: locked(url.removeprefix("sqlite:///"))
    url = request.getfixturevalue("postgresql_url")
    server: PostgreSQL = request.getfixturevalue("postgresql_server")
    return url, (lambda: stopped(server)) if kind == "postgresql stopped" else server.frozen
