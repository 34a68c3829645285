"""Port, clock, disk and database."""

import shutil
import socket
import sqlite3
from collections import namedtuple
from pathlib import Path

import pytest

from dock_gateway.doctor.check import Level
from dock_gateway.doctor.machine import check_clock, check_database, check_disk, check_port
from dock_gateway.settings import Settings


def test_a_port_that_is_free_and_one_of_another_program() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        settings = Settings(port=taken.getsockname()[1])
        check = check_port(settings)
    assert check.level is Level.ERROR
    assert "--port takes another" in check.text
    assert check_port(settings).level is Level.OK


def test_clocks() -> None:
    assert check_clock(synchronized=True).level is Level.OK
    assert check_clock(synchronized=False).level is Level.WARNING
    assert check_clock(lambda: 0.0, synchronized=True).level is Level.ERROR
    assert "1970-01-01" in check_clock(lambda: 0.0).text


@pytest.mark.parametrize(
    ("free", "level"), [(10_000_000_000, Level.OK), (500_000_000, Level.WARNING), (1_000_000, Level.ERROR)]
)
def test_space(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, free: int, level: Level) -> None:
    monkeypatch.setattr(shutil, "disk_usage", lambda _: namedtuple("Usage", "free")(free))  # noqa: PYI024
    check = check_disk(Settings(database_url=f"sqlite:///{tmp_path}/new/history.db"))
    assert check.level is level
    assert str(tmp_path) in check.text


def test_databases(tmp_path: Path) -> None:
    path = tmp_path / "history.db"
    settings = Settings(database_url=f"sqlite:///{path}")
    assert "is made at the first start" in check_database(settings).text
    with sqlite3.connect(path) as database:
        database.execute("CREATE TABLE goals (id)")
    database.close()
    assert check_database(settings).level is Level.OK
    path.write_bytes(b"no database" * 1000)
    assert check_database(settings).level is Level.WARNING
    assert check_database(Settings(database_url=f"sqlite:///{tmp_path}")).level is Level.ERROR
    assert check_database(Settings(database_url="memory:")).level is Level.OK


def test_a_database_server_that_does_not_answer() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
    check = check_database(Settings(database_url=f"postgresql://ada:secret@127.0.0.1:{port}/history"))
    assert check.level is Level.ERROR
    assert "does not answer" in check.text
    assert "secret" not in check.text
