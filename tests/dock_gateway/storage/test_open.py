"""Where the history is kept follows from the settings."""

import os
from pathlib import Path

import pytest
from pydantic import ValidationError

from dock_gateway.settings import Settings
from dock_gateway.storage import HistoryStats, Spool, open_history
from tests.support.history import make_goal, page_of


async def test_in_the_data_directory_of_the_user(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "7")
    async with open_history(Settings()) as history:
        await history.add(make_goal(1))
        assert history.stats().database_reachable
    assert (Path(os.environ["XDG_DATA_HOME"]) / "dock-gateway" / "history-7-localhost.db").exists()
    async with open_history(Settings()) as history:
        assert await history.get("goal-0001") is not None
    monkeypatch.setenv("ROS_DOMAIN_ID", "8")
    async with open_history(Settings()) as history:
        assert await history.get("goal-0001") is None


async def test_where_the_settings_say(tmp_path: Path) -> None:
    path = tmp_path / "a b%20c?" / "history.db"
    async with open_history(Settings(database_url=f"sqlite:///{path}", spool_path=tmp_path / "spool")) as history:
        await history.add(make_goal(1))
        assert await history.get("goal-0001") is not None
    assert path.exists()


def files_in(folder: Path) -> list[Path]:
    return sorted(folder.rglob("*"))


async def test_in_memory(tmp_path: Path) -> None:
    """It leaves what gateways with a database have on the disk as it is, and adds nothing."""
    settings = Settings(database_url="memory:", spool_path=tmp_path / "spool")
    other = Spool(settings.spool_folder)
    await other.append([make_goal(1)])
    await other.close()
    files = files_in(tmp_path)
    async with open_history(settings) as history:
        await history.add(make_goal(2), "key")
        assert await history.get("goal-0001") is None
        assert await history.by_key("key") is not None
        assert history.stats() == HistoryStats(waiting=history.stats().waiting)
    assert files_in(tmp_path) == files
    async with open_history(settings) as history:
        assert await page_of(history) == []


async def test_on_postgresql(postgresql_url: str, tmp_path: Path) -> None:
    for url in (postgresql_url, f"{postgresql_url.replace('postgresql:', 'postgres:')}?sslmode=prefer"):
        async with open_history(Settings(database_url=url, spool_path=tmp_path / "spool")) as history:
            await history.add(make_goal(1))
            assert history.stats().database_reachable, history.stats()


@pytest.mark.parametrize("url", ["mysql://host/name", "sqlite://", "history.db"])
def test_other_places_are_refused(url: str) -> None:
    with pytest.raises(ValidationError, match="database_url"):
        Settings(database_url=url)
