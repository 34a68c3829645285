"""The tables come into being, once, whoever else is at it, and are those of `tables.py`."""

import asyncio
import subprocess
import sys
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TypeVar

import pytest
import sqlalchemy as sa
from alembic.autogenerate import compare_metadata
from alembic.config import Config
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory

from dock_gateway.automation.rule import BatteryCondition, RuleEntry, Schedule
from dock_gateway.core.access import PersonSession, Session, Token, User
from dock_gateway.core.audit import AuditEntry
from dock_gateway.core.automation import Decision, Mode, Outcome
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.core.grant import Role
from dock_gateway.core.webhook import Delivery, DeliveryState, EventType
from dock_gateway.http.schema import RobotSelection
from dock_gateway.storage import Acknowledgement, RobotLabel
from dock_gateway.storage.migrate import HEAD, MIGRATIONS, migrate
from dock_gateway.storage.rows import goal_row
from dock_gateway.storage.sql import open_database
from dock_gateway.storage.tables import goals, metadata, prepare_for
from dock_gateway.webhooks.webhook import WebhookEntry
from tests.support.history import NOW, make_goal, open_at, written
from tests.support.waiting import until

T = TypeVar("T")

EARLY_REVISION = "0012"
USER = """
INSERT INTO users (name, role, robots, actions, topics, password, era, disabled, created_at)
VALUES ('ada', 'admin', '["/robot1","/hall_a/*"]', '[]', '[]', 'p', 'e', false, '2026-01-01 12:00:00.123456')
"""
PROGRAM = [sys.executable, "-m", "tests.support.history"]


async def carry_out(url: str, work: Callable[[sa.Connection], T]) -> T:
    """A transaction in a database that nobody has made tables in."""
    if url.startswith("sqlite"):
        prepare_for("sqlite")
        engine = sa.create_engine(url)
        with engine.begin() as connection:
            done = work(connection)
        engine.dispose()
        return done
    database = open_database(url)
    try:
        return await database.write(work)
    finally:
        await database.close()


def make_earlier_tables(connection: sa.Connection) -> None:
    """Make the tables as the migrations before the baseline did."""
    statements = (Path(__file__).parent / "revision_0018.sql").read_text()
    if connection.dialect.name == "sqlite":
        statements = statements.replace(' COLLATE "C"', "").replace("TIMESTAMP WITH TIME ZONE", "DATETIME")
    for statement in statements.split(";\n"):
        connection.execute(sa.text(statement))


def set_revision(connection: sa.Connection, revision: str) -> None:
    connection.execute(sa.text("UPDATE alembic_version SET version_num = :revision"), {"revision": revision})


def make_early_tables(connection: sa.Connection) -> None:
    """Make tables that call themselves older than the baseline, with a goal and a user."""
    make_earlier_tables(connection)
    set_revision(connection, EARLY_REVISION)
    insert(connection, make_goal(1), without=())
    connection.exec_driver_sql(USER)


def contents(connection: sa.Connection) -> tuple[str | None, list[str], list[str]]:
    """The revision, the goals and the users of a database."""
    revision = connection.scalar(sa.text("SELECT version_num FROM alembic_version"))
    users = sa.text(
        "SELECT name FROM users"
        if sa.inspect(connection).has_table("users")
        else "SELECT key FROM documents WHERE kind = 'user'"
    )
    return revision, [*connection.scalars(sa.select(goals.c.goal_id))], [*connection.scalars(users)]


def insert(connection: sa.Connection, goal: Goal, *, without: tuple[str, ...]) -> None:
    """Insert a goal as an earlier version did that lacks these columns."""
    row = {name: value for name, value in goal_row(goal).items() if name not in without}
    connection.execute(sa.insert(goals).values(row))


@pytest.mark.parametrize("make", [migrate, make_earlier_tables], ids=["new", "of the baseline"])
async def test_the_tables_are_those_that_the_code_expects(
    database_url: str, make: Callable[[sa.Connection], None]
) -> None:
    def differences(connection: sa.Connection) -> list[Any]:
        make(connection)
        migrate(connection)
        return compare_metadata(MigrationContext.configure(connection), metadata)

    assert await carry_out(database_url, differences) == []


async def test_a_new_database_has_the_newest_revision(database_url: str) -> None:
    def revision(connection: sa.Connection) -> str | None:
        migrate(connection)
        migrate(connection)
        return contents(connection)[0]

    assert await carry_out(database_url, revision) == HEAD
    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS))
    assert ScriptDirectory.from_config(config).get_current_head() == HEAD


async def test_the_database_of_the_baseline_is_upgraded(database_url: str, tmp_path: Path) -> None:
    def make_tables(connection: sa.Connection) -> None:
        make_early_tables(connection)
        set_revision(connection, "0018")

    await carry_out(database_url, make_tables)
    async with open_at(database_url, tmp_path) as history:
        goal = await history.get("goal-0001")
        assert goal is not None
        assert (goal.goal, goal.status) == (b'{"order":5}', GoalStatus.SUCCEEDED)
        assert (await history.documents("user", User).read())["ada"].password == "p"
        await history.add(make_goal(2))
        await history.documents("token", Token).write(
            "t", Token("name", Role.OPERATOR, (), (), (), "digest", None, NOW, None, None)
        )
        entry = AuditEntry("e", NOW, None, None, None, None, None, "login", None, None, None, None, 200, None)
        assert [row.sequence for row in await history.audit.append([entry])] == [1]
        assert await history.database.read(contents) == (HEAD, ["goal-0001", "goal-0002"], ["ada"])


RULES_AND_WEBHOOKS = """
INSERT INTO automation_rules VALUES ('low', 'Löw', 'on', false, '["/robot1"]', '["hall 1"]', 0.2, 60,
    '[]', '[]', NULL, NULL, '2026-01-01 12:00:00.123456');
INSERT INTO automation_rules VALUES ('night', 'Night', 'dry_run', true, '[]', '[]', NULL, NULL,
    '["22:00"]', '["mon"]', 'Europe/Berlin', 'Ada', '2026-01-01 12:00:00.123456');
INSERT INTO webhooks VALUES ('a', 'Büro', 'https://x/ü', 'whsec_a', false, '["critical"]', false,
    '["/a"]', '["hall 1"]', 'Ada', '2026-01-01 12:00:00.123456');
INSERT INTO webhooks VALUES ('b', 'Hook', 'http://x', 'whsec_b', true, '["critical","warning"]', true,
    '[]', '[]', NULL, '2026-01-01 12:00:00.123456')
"""


async def test_rules_and_webhooks_of_the_baseline_become_documents(database_url: str, tmp_path: Path) -> None:
    def make_tables(connection: sa.Connection) -> None:
        make_earlier_tables(connection)
        if connection.dialect.name == "postgresql":
            connection.execute(sa.text("SET LOCAL timezone = 'UTC'"))
        for statement in RULES_AND_WEBHOOKS.split(";"):
            connection.exec_driver_sql(statement)

    at = datetime(2026, 1, 1, 12, 0, 0, 123456, tzinfo=UTC)
    chosen, every = RobotSelection(names=("/robot1",), groups=("hall 1",)), RobotSelection(all=True)
    battery = BatteryCondition(below=0.2, idle_s=60)
    schedule = Schedule(times=["22:00"], weekdays=["mon"], time_zone="Europe/Berlin")
    low = RuleEntry(name="Löw", mode=Mode.ON, robots=chosen, battery=battery, changed_by=None, changed_at=at)
    night = RuleEntry(name="Night", mode=Mode.DRY_RUN, robots=every, schedule=schedule, changed_by="Ada", changed_at=at)
    office = WebhookEntry(
        name="Büro",
        url="https://x/ü",
        secret="whsec_a",
        enabled=False,
        severities=["critical"],
        robots=RobotSelection(names=("/a",), groups=("hall 1",)),
        changed_by="Ada",
        changed_at=at,
    )
    hook = WebhookEntry(name="Hook", url="http://x", secret="whsec_b", changed_by=None, changed_at=at)
    await carry_out(database_url, make_tables)
    async with open_at(database_url, tmp_path) as history:
        assert await history.documents("rule", RuleEntry).read() == {"low": low, "night": night}
        assert await history.documents("webhook", WebhookEntry).read() == {"a": office, "b": hook}


ROWS = (
    USER
    + """;
INSERT INTO acknowledgements VALUES ('alert', 'Zoë', '2026-01-01 12:00:00.123456');
INSERT INTO robot_labels VALUES ('/robot1', 'Left', '["hall 1"]');
INSERT INTO robot_labels VALUES ('/robot2', NULL, '[]');
INSERT INTO automation_decisions VALUES ('d', 'low', 'Löw', '/robot1', '2026-01-01 12:00:00.123456', 'sent', 0.1,
    '2026-01-01 12:00:00.123456', NULL, 'goal', NULL, 'why', true);
INSERT INTO webhook_deliveries VALUES ('w', 'hook', 'alert.raised', 'pending', 'alert', '2026-01-01 12:00:00.123456',
    '{"text":"ü","n":1.0}', 2, '2026-01-01 12:00:00.123456', NULL, 204, NULL);
INSERT INTO tokens (token_id, name, role, robots, actions, topics, digest, created_at)
    VALUES ('t', 'script', 'operator', '["/robot1"]', '["/dock"]', '["/map"]', 'dd', '2026-01-01 12:00:00.123456');
INSERT INTO sessions (session_id, user_name, era, digest, created_at, expires_at, used_at)
    VALUES ('s', 'ada', 'e', 'ds', '2026-01-01 12:00:00.123456', '2026-01-01 12:00:00.123456',
    '2026-01-01 12:00:00.123456');
INSERT INTO person_sessions (session_id, person, issuer, subject, role, robots, actions, topics, digest, attempt,
    created_at, expires_at, used_at) VALUES ('p', 'oidc:bob', 'https://x', '1', 'viewer', '[]', '[]', '[]', 'dp', 'a',
    '2026-01-01 12:00:00.123456', '2026-01-01 12:00:00.123456', '2026-01-01 12:00:00.123456')
"""
)


async def test_the_other_small_tables_of_the_baseline_become_documents(database_url: str, tmp_path: Path) -> None:
    def make_tables(connection: sa.Connection) -> None:
        make_earlier_tables(connection)
        if connection.dialect.name == "postgresql":
            connection.execute(sa.text("SET LOCAL timezone = 'UTC'"))
        for statement in ROWS.split(";"):
            connection.exec_driver_sql(statement)

    at = datetime(2026, 1, 1, 12, 0, 0, 123456, tzinfo=UTC)
    body = '{"text":"ü","n":1.0}'.encode()
    raised, pending = EventType.RAISED, DeliveryState.PENDING
    expected: dict[tuple[str, type[Any]], dict[str, Any]] = {
        ("acknowledgement", Acknowledgement): {"alert": Acknowledgement("Zoë", at)},
        ("label", RobotLabel): {"/robot1": RobotLabel("Left", ("hall 1",)), "/robot2": RobotLabel(None, ())},
        ("decision", Decision): {
            "d": Decision("low", "Löw", "/robot1", at, Outcome.SENT, 0.1, at, None, "goal", None, "why", open=True)
        },
        ("delivery", Delivery): {"w": Delivery("hook", raised, pending, "alert", at, body, 2, at, None, 204, None)},
        ("token", Token): {
            "t": Token("script", Role.OPERATOR, ("/robot1",), ("/dock",), ("/map",), "dd", None, at, None, None)
        },
        ("user", User): {"ada": User(Role.ADMIN, ("/robot1", "/hall_a/*"), (), (), "p", "e", False, None, at, None)},
        ("session", Session): {"s": Session("ada", "e", "ds", at, at, at)},
        ("person_session", PersonSession): {
            "p": PersonSession("oidc:bob", "https://x", "1", Role.VIEWER, (), (), (), "dp", "a", at, at, at)
        },
    }
    await carry_out(database_url, make_tables)
    async with open_at(database_url, tmp_path) as history:
        for (kind, model), entries in expected.items():
            assert await history.documents(kind, model).read() == entries


async def test_a_sqlite_file_of_before_the_first_release_is_set_aside(
    sqlite_url: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    await carry_out(sqlite_url, make_early_tables)
    kept = tmp_path / f"history.db.{EARLY_REVISION}"
    async with (
        open_at(sqlite_url, tmp_path / "one") as history,
        open_at(sqlite_url, tmp_path / "another") as other,
    ):
        assert (history.stats().database_reachable, other.stats().database_reachable) == (True, True)
        assert await history.get("goal-0001") is None
        await history.add(make_goal(2))
        assert await other.get("goal-0002") is not None
        incident = history.incident
        assert incident is not None
        assert f"is kept as {kept}" in incident.detail
        assert history.stats().last_error == incident.detail
        assert other.incident is None, "it has not lost anything"
        assert caplog.text.count("tables from before the first release") == 1
        prepare_for("sqlite")
        assert await carry_out(f"sqlite:///{kept}", contents) == (EARLY_REVISION, ["goal-0001"], ["ada"])
        kept.unlink()
        await until(lambda: history.stats().last_error is None)


async def test_no_file_is_overwritten_by_one_that_is_set_aside(sqlite_url: str, tmp_path: Path) -> None:
    await carry_out(sqlite_url, make_early_tables)
    kept = tmp_path / f"history.db.{EARLY_REVISION}"
    kept.write_text("of last time")
    async with open_at(sqlite_url, tmp_path) as history:
        await history.add(make_goal(2))
        assert f"cannot be renamed to {kept}" in (history.stats().last_error or "")
        assert history.stats().spooled == 1
        assert kept.read_text() == "of last time"
        kept.rename(tmp_path / "elsewhere")
        await written(history)
    assert await carry_out(f"sqlite:///{kept}", contents) == (EARLY_REVISION, ["goal-0001"], ["ada"])
    assert (await carry_out(sqlite_url, contents))[1] == ["goal-0002"]


async def test_a_postgresql_database_of_before_the_first_release_is_left_alone(
    postgresql_url: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    await carry_out(postgresql_url, make_early_tables)
    async with open_at(postgresql_url, tmp_path) as history:
        await history.add(make_goal(2))
        stats = history.stats()
        assert (stats.database_reachable, stats.spooled) == (False, 1)
        assert "tables from before the first release (revision 0012)" in (stats.last_error or "")
        assert "DOCK_GATEWAY_DATABASE_URL" in (stats.last_error or ""), "what to do is said in full"
    assert "tables from before the first release" in caplog.text
    assert await carry_out(postgresql_url, contents) == (EARLY_REVISION, ["goal-0001"], ["ada"])


async def test_earlier_goals_get_their_verb_from_their_type(database_url: str, tmp_path: Path) -> None:
    types = {"ConnectToChargingDock": "dock", "DisconnectFromChargingDock": "undock", "Fibonacci": None}

    def make_tables(connection: sa.Connection) -> None:
        make_earlier_tables(connection)
        for number, name in enumerate(types):
            goal = make_goal(number, action_type=f"action_tutorials_interfaces/action/{name}")
            insert(connection, goal, without=("verb",))

    await carry_out(database_url, make_tables)
    async with open_at(database_url, tmp_path) as history:
        goals = await history.known([f"goal-{number:04d}" for number in range(len(types))])
        assert [goal.verb for _, goal in sorted(goals.items())] == [*types.values()]


async def test_a_goal_of_the_tutorials_type_on_another_action_has_no_verb(database_url: str, tmp_path: Path) -> None:
    other = make_goal(1, action_type="action_tutorials_interfaces/action/ConnectToChargingDock")
    async with open_at(database_url, tmp_path) as history:
        await history.add(other)
    async with open_at(database_url, tmp_path) as history:
        assert (await history.known([other.goal_id]))[other.goal_id].verb is None


async def test_an_older_gateway_goes_on_with_its_goals(database_url: str, tmp_path: Path) -> None:
    """In a rolling upgrade it writes no verb, to tables that have one."""
    async with open_at(database_url, tmp_path) as history:
        await history.database.write(lambda connection: insert(connection, make_goal(1), without=("verb",)))
        goal = await history.get("goal-0001")
        assert goal is not None
        assert goal.verb is None
        goal.verb = "dock"
        await history.add(goal)
        assert (await history.known(["goal-0001"]))["goal-0001"].verb == "dock"


async def test_replicas_start_at_the_same_time(database_url: str, tmp_path: Path) -> None:
    """Processes that find no tables, and claim the same key: one makes the tables, and one gets the key."""

    async def claim(name: str) -> list[str]:
        process = await asyncio.create_subprocess_exec(
            *PROGRAM, "claim", database_url, str(tmp_path), "key", name, stdout=subprocess.PIPE
        )
        output, _ = await asyncio.wait_for(process.communicate(), 30)
        return output.decode().split()

    answers = await asyncio.gather(*(claim(f"g{number}") for number in range(3)))
    assert {answer[2] for answer in answers} == {"True"}, "each of them reached the database"
    assert len({answer[0] for answer in answers}) == 1, answers


async def test_the_tables_of_a_newer_version_are_left_alone(
    database_url: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    newer = sa.text("UPDATE alembic_version SET version_num = '9999'")
    async with open_at(database_url, tmp_path) as history:
        await history.database.write(lambda connection: connection.execute(newer) and None)
    async with open_at(database_url, tmp_path) as history:
        await history.add(make_goal(1))
        stats = history.stats()
        assert not stats.database_reachable
        assert stats.spooled == 1
        assert "another version of the gateway" in (stats.last_error or "")
        assert await history.get("goal-0001") is not None
    assert "another version of the gateway" in caplog.text
