"""Users and tokens: which database a command uses is said, and which others there are."""

import os
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from dock_gateway.access.logins import Logins
from dock_gateway.access.tokens import SAID_EVERY
from dock_gateway.cli import main
from dock_gateway.core.errors import NotAuthenticated
from dock_gateway.storage.database import display
from tests.support.history import HistoryInMemory

DEFAULT, LOCAL, OTHER = "history-0.db", "history-0-localhost.db", "history-42.db"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The user's data directory, in a terminal without any variable of the gateway."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    for name in ("DOCK_GATEWAY_DATABASE_URL", "ROS_DOMAIN_ID", "ROS_AUTOMATIC_DISCOVERY_RANGE"):
        monkeypatch.delenv(name, raising=False)
    folder = tmp_path / "dock-gateway"
    folder.mkdir()
    return folder


def run(*arguments: str) -> Result:
    return CliRunner().invoke(main, arguments)


def use(folder: Path, name: str) -> None:
    """Leave a database as a gateway that runs has it."""
    (folder / name).touch()
    (folder / f"{name}-wal").touch()


def test_what_is_written_where_is_said_and_the_secret_stands_alone(folder: Path) -> None:
    done = run("token", "create", "night shift")
    assert done.stdout.startswith("dgw_")
    assert done.stdout.count("\n") == 1
    assert done.stderr == f"stored in sqlite:///{folder / DEFAULT}\n"
    assert run("token", "list").stderr == f"read in sqlite:///{folder / DEFAULT}\n"
    assert run("user", "list").stderr == f"read in sqlite:///{folder / DEFAULT}\n"
    missing = run("token", "delete", "day shift")
    assert missing.exit_code == 1
    assert f"looked in sqlite:///{folder / DEFAULT}" in missing.stderr
    assert "there is no token day shift" in missing.stderr


def test_the_database_of_a_running_gateway_is_named(folder: Path) -> None:
    use(folder, LOCAL)
    done = run("token", "create", "a")
    assert f"stored in sqlite:///{folder / DEFAULT}" in done.stderr
    assert "WARNING: a gateway seems to use another database" in done.stderr
    assert f"--database-url sqlite:///{folder / LOCAL}" in done.stderr
    assert done.stdout.count("\n") == 1  # whatever is said, a script gets the secret
    use(folder, OTHER)
    both = run("token", "list").stderr
    assert str(folder / LOCAL) in both
    assert str(folder / OTHER) in both
    given = run("token", "create", "b", "--database-url", f"sqlite:///{folder / 'elsewhere.db'}")
    assert "WARNING" in given.stderr  # it may be a variable that this terminal has left


def test_other_databases_are_named_though_no_gateway_runs(folder: Path) -> None:
    (folder / OTHER).touch()
    done = run("token", "create", "a")
    assert "WARNING: a gateway with another ROS_DOMAIN_ID or discovery range has used its own since" in done.stderr
    assert f"--database-url sqlite:///{folder / OTHER}" in done.stderr
    given = run("token", "create", "b", "--database-url", f"sqlite:///{folder / DEFAULT}")
    assert "WARNING" not in given.stderr


def test_a_database_that_was_used_before_this_one_is_no_reason_to_warn(folder: Path) -> None:
    (folder / OTHER).touch()
    assert "WARNING" in run("token", "create", "first").stderr
    assert "WARNING" not in run("token", "create", "second").stderr
    later = (folder / DEFAULT).stat().st_mtime + 1
    os.utime(folder / OTHER, (later, later))
    assert "WARNING" in run("token", "create", "third").stderr


def test_what_the_running_gateway_uses_is_no_reason_to_warn(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run("token", "create", "first")
    use(folder, DEFAULT)
    (folder / OTHER).touch()
    assert "WARNING" not in run("token", "list").stderr
    monkeypatch.setenv("ROS_DOMAIN_ID", "42")
    use(folder, DEFAULT)  # the command before has closed it
    assert "WARNING" in run("token", "list").stderr


@pytest.mark.parametrize(
    ("url", "shown"),
    [
        ("postgresql://dock:secret@db.example/dock?password=secret", "postgresql://dock:***@db.example/dock"),
        ("postgresql:///dock", "postgresql:///dock"),
        ("sqlite:////var/lib/dock-gateway/history.db", "sqlite:////var/lib/dock-gateway/history.db"),
        ("memory:", "memory:"),
    ],
)
def test_no_password_is_shown(url: str, shown: str) -> None:
    assert display(url) == shown


async def test_the_gateway_s_log_says_where_its_tokens_are_once(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The answer says nothing of it."""
    clock = [0.0]
    monkeypatch.setattr("dock_gateway.access.tokens.time.monotonic", lambda: clock[0])
    logins = Logins(HistoryInMemory(), where="sqlite:////here.db")
    for now in (0.0, 1.0, SAID_EVERY + 1.0):
        clock[0] = now
        for secret in ("dgw_unknown", "something else"):
            with pytest.raises(NotAuthenticated) as refused:
                logins.identify(secret)
            assert refused.value.detail == "the token is not known, was revoked or has expired"
    assert [record.getMessage()[:57] for record in caplog.records] == [
        "a token was shown that is not in sqlite:////here.db. It w"
    ] * 2
