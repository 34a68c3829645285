"""The missions in the database of a run, and the tags of their steps."""

import json
from datetime import datetime
from typing import Any

import sqlalchemy as sa
from pydantic import TypeAdapter

from dock_gateway.extensions.missions.mission import MissionEntry
from dock_gateway.storage.tables import documents, idempotency_keys
from tests.dock_gateway.simulation.database import Disk

MISSION = TypeAdapter(MissionEntry)


def stored_missions(disk: Disk, kind: str) -> dict[str, MissionEntry]:
    """Return the missions of a kind: `mission` or `ended_mission`."""
    query = sa.select(documents.c.key, documents.c.document).where(documents.c.kind == kind)
    with disk.engine.begin() as connection:
        rows = connection.execute(query).all()
    return {key: MISSION.validate_json(document, extra="ignore") for key, document in rows}


def share_docks(disk: Disk, names: list[str], at: datetime) -> None:
    """Enter docks as shared ones, as an extension stores them that lets a dock have one robot."""
    dock = {"changed_by": None, "changed_at": at.isoformat()}
    rows = [{"kind": "shared_dock", "key": name, "document": json.dumps(dock).encode()} for name in names]
    with disk.engine.begin() as connection:
        connection.execute(sa.insert(documents), rows)


def key_of(disk: Disk, goal_id: str) -> str | None:
    """Return the idempotency key of a goal."""
    query = sa.select(idempotency_keys.c.key).where(idempotency_keys.c.goal_id == goal_id)
    with disk.engine.begin() as connection:
        return connection.scalars(query).first()


def robot_of(mission: MissionEntry) -> str:
    """Return the robot of a mission; empty: none has it yet."""
    return mission.robot or ""


def tag_of(step: Any) -> str | None:
    """Return the tag of a step; None if it does nothing at a robot."""
    request = step.call.request if step.call is not None else step.request
    return (request or {}).get("tag")


def named(tag: str, mission_id: str) -> str:
    """Return a tag that no other mission has: all missions of a schedule have the same tags."""
    return f"{tag}@{mission_id}" if tag.startswith("s") else tag
