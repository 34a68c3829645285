"""`dock-gateway audit verify`."""

import asyncio
from pathlib import Path

import pytest
from click.testing import CliRunner

from dock_gateway.cli import main
from tests.support.audit import change, make_entry, statement
from tests.support.history import open_at
from tests.support.waiting import until


def test_on_the_command_line(database_url: str, tmp_path: Path) -> None:
    def verified(*options: str) -> tuple[int, str]:
        result = CliRunner().invoke(main, ["audit", "verify", "--database-url", database_url, *options])
        assert result.stderr.startswith("read in ")
        return result.exit_code, result.output.partition("\n")[2]

    async def fill() -> list[str]:
        async with open_at(database_url, tmp_path) as history:
            await until(lambda: history.stats().database_reachable)
            return [row.digest for row in await history.audit.append([make_entry(number) for number in range(3)])]

    assert verified() == (0, "there are no rows\n")
    digests = asyncio.run(fill())
    assert verified("--expect", digests[1].upper()) == (
        0,
        f"3 rows are intact: 1 to 3\ndigest of row 3: {digests[2]}\n",
    )
    status, output = verified("--expect", "0" * 63 + "1")
    assert (status, "no row has the digest" in output) == (1, True)
    asyncio.run(change(database_url, statement("UPDATE audit SET client = NULL WHERE sequence = 2")))
    status, output = verified()
    assert status == 1
    assert "1 rows are intact: 1 to 1" in output
    assert "row 2 was changed" in output


def test_the_command_says_what_it_cannot_do() -> None:
    memory = CliRunner().invoke(main, ["audit", "verify", "--database-url", "memory:"])
    assert (memory.exit_code, "keeps no audit log" in memory.output) == (2, True)
    nowhere = CliRunner().invoke(main, ["audit", "verify", "--database-url", "postgresql://x@127.0.0.1:1/x"])
    assert (nowhere.exit_code, "does not answer" in nowhere.output) == (1, True)


def test_the_database_that_was_read_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path))
    done = CliRunner().invoke(main, ["audit", "verify", "--database-url", f"sqlite:///{tmp_path}/history.db"])
    assert f"sqlite:///{tmp_path}/history.db" in done.stderr
