"""The settings of what is stored: where, and for how long."""

import importlib.util
from pathlib import Path
from typing import Annotated, ClassVar

from pydantic import Field, field_validator

from dock_gateway.setting_groups.group import SettingsGroup
from dock_gateway.setting_types import TUNING, Days, Megabytes


class HistorySettings(SettingsGroup):
    """The settings of what is stored: where, and for how long."""

    group: ClassVar[str] = "History"

    database_url: str = Field(
        "",
        pattern=r"^(memory:|sqlite:///.+|postgres(ql)?://.*)?$",
        description="URL of the history database: `postgresql://user@host/name`, `sqlite:////path/to/history.db`, or "
        "`memory:`. Empty: SQLite, `history-<ROS_DOMAIN_ID>.db` in the user's data directory, or "
        "`history-<ROS_DOMAIN_ID>-localhost.db` if discovery is limited to this machine. PostgreSQL needs "
        "`dock-gateway[postgresql]`.",
    )
    spool_path: Path | None = Field(
        None,
        description="Folder for goals while the database is not available. Empty: `spool-<ROS_DOMAIN_ID>` in the "
        "user's data directory, or `spool-<ROS_DOMAIN_ID>-localhost` if discovery is limited to this machine.",
    )
    stop_path: Path | None = Field(
        None,
        description="File that keeps latched stops across restarts. Empty: `stops-<ROS_DOMAIN_ID>.json` in the "
        "user's data directory, or `stops-<ROS_DOMAIN_ID>-localhost.json` if discovery is limited to "
        "this machine.",
    )
    feedback_retention_days: float = Field(
        7.0,
        gt=0,
        le=365_000,
        description="Days for which feedback and battery events are kept. Status and result events are kept as long "
        "as their goal.",
    )
    feedback_retention_mb: Megabytes = Field(
        256,
        description="Maximum size of the stored feedback and battery events, in megabytes. The oldest are deleted "
        "first.",
    )
    goal_retention_days: Days = Field(
        365.0,
        description="Days for which goals are kept, with their status and result events. Goals that have not ended "
        "are not deleted.",
    )
    goal_retention_mb: Megabytes = Field(
        1000,
        description="Maximum size of the stored goals with their status and result events, in megabytes. The oldest "
        "ended goals are deleted first.",
    )
    audit_retention_days: Days = Field(
        365.0,
        description="Days for which the entries of the audit log are kept.",
    )
    audit_max_entries: Annotated[int, TUNING] = Field(
        1_000_000,
        ge=1000,
        description="Maximum number of entries of the audit log, about 0.6 kB each. The oldest are deleted first.",
    )
    memory_max_goals: Annotated[int, TUNING] = Field(
        1000, ge=10, description="Maximum number of ended goals in the history `memory:`. The oldest are deleted first."
    )
    history_queue: Annotated[int, TUNING] = Field(
        10_000,
        ge=100,
        description="Maximum number of feedback and battery events that wait for the database. Beyond it, the oldest "
        "are dropped.",
    )

    @field_validator("database_url")
    @classmethod
    def _check_driver(cls, url: str) -> str:
        if url.startswith("postgres") and importlib.util.find_spec("asyncpg") is None:
            raise ValueError("dock-gateway[postgresql] is not installed")
        return url
