"""Databases for the tests of the history: real ones, fresh for each test; quick passwords."""

import asyncio
import itertools
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import asyncpg
import pytest

from dock_gateway.access import login_guard, passwords
from dock_gateway.storage import immediate, reader, writer
from tests.support.postgresql import PostgreSQL, binaries, running_postgresql

_numbers = itertools.count()


@pytest.fixture(autouse=True)
def history_timeouts(monkeypatch: pytest.MonkeyPatch) -> None:
    """The database of a busy machine takes its time; without an answer a goal would go to the spool, say."""
    monkeypatch.setattr("dock_gateway.storage.history.OPEN_TIMEOUT", 30.0)
    monkeypatch.setattr(writer, "ANSWER_TIMEOUT", 30.0)
    monkeypatch.setattr(reader, "READ_TIMEOUT", 30.0)
    monkeypatch.setattr(immediate, "WRITE_TIMEOUT", 30.0)


@pytest.fixture(scope="session")
def postgresql_server() -> Iterator[PostgreSQL]:
    if binaries() is None:
        pytest.skip("PostgreSQL IS NOT TESTED: there is no server on this machine, and no package with one for it")
    with running_postgresql() as server:
        yield server


@pytest.fixture
def postgresql_url(postgresql_server: PostgreSQL) -> str:
    name = f"test_{next(_numbers)}"

    async def create() -> None:
        connection = await asyncpg.connect(postgresql_server.url)
        await connection.execute(f"CREATE DATABASE {name}")
        await connection.close()

    asyncio.run(create())
    return postgresql_server.database(name)


@pytest.fixture
def sqlite_url(tmp_path: Path) -> str:
    return f"sqlite:///{tmp_path}/history.db"


@pytest.fixture(params=["sqlite", "postgresql"])
def database_url(request: pytest.FixtureRequest) -> str:
    url: str = request.getfixturevalue(f"{request.param}_url")
    return url


@pytest.fixture(params=["memory", "sqlite", "postgresql"])
def place(request: pytest.FixtureRequest) -> str:
    """Each of the places where a history can be: a URL, as `open_place` takes it."""
    url: str = "memory:" if request.param == "memory" else request.getfixturevalue(f"{request.param}_url")
    return url


@pytest.fixture
def quick_hashes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Passwords are hashed as weakly as possible: a test makes many."""
    monkeypatch.setattr(passwords, "COST", passwords.Cost(memory=8, passes=1, lanes=1))


@pytest.fixture
def stopped_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    """No time goes by between two logins."""
    monkeypatch.setattr(login_guard, "time", SimpleNamespace(monotonic=lambda: 1000.0))
