"""The missions in the database of a run, and the tags of their steps."""

import json
from collections.abc import Iterable, Mapping
from datetime import datetime
from functools import lru_cache
from typing import Any

import sqlalchemy as sa
from pydantic import TypeAdapter

from dock_gateway.extensions.missions.mission import MissionEntry
from dock_gateway.storage.tables import documents, idempotency_keys
from tests.dock_gateway.simulation.database import Disk

MISSION = TypeAdapter(MissionEntry)


@lru_cache(maxsize=5000)
def read_mission(document: bytes) -> MissionEntry:
    """Return a mission that is stored; most are read many times."""
    return MISSION.validate_json(document, extra="ignore")


def stored_missions(disk: Disk, kind: str) -> dict[str, MissionEntry]:
    """Return the missions of a kind: `mission` or `ended_mission`."""
    query = sa.select(documents.c.key, documents.c.document).where(documents.c.kind == kind)
    with disk.engine.begin() as connection:
        rows = connection.execute(query).all()
    return {key: read_mission(document) for key, document in rows}


def find_missions(connection: sa.Connection, keys: Iterable[str]) -> dict[str, MissionEntry]:
    """Return those of some missions that have not ended. It is asked often: SQL as text takes the least time."""
    query, found = "SELECT document FROM documents WHERE kind = 'mission' AND key = ?", {}
    for key in keys:
        if (row := connection.exec_driver_sql(query, (key,)).first()) is not None:
            found[key] = read_mission(row[0])
    return found


def share_docks(disk: Disk, places: Mapping[str, list[dict[str, Any]]], at: datetime) -> None:
    """Enter docks as shared ones, as an extension stores them that lets a dock have one robot.

    Args:
        disk: The database.
        places: Where robots wait for each dock.
        at: The time.
    """
    dock = {"changed_by": None, "changed_at": at.isoformat()}
    rows = [
        {"kind": "shared_dock", "key": name, "document": json.dumps(dock | {"waiting_places": found}).encode()}
        for name, found in places.items()
    ]
    with disk.engine.begin() as connection:
        connection.execute(sa.insert(documents), rows)


def _stored_json(disk: Disk, kind: str) -> dict[str, dict[str, Any]]:
    query = sa.select(documents.c.key, documents.c.document).where(documents.c.kind == kind)
    with disk.engine.begin() as connection:
        return {key: json.loads(document) for key, document in connection.execute(query)}


def dock_records(disk: Disk) -> dict[str, dict[str, Any]]:
    """Return what has happened at the shared docks, as an extension stores it."""
    return _stored_json(disk, "dock_record")


def dock_waits(disk: Disk) -> dict[str, dict[str, Any]]:
    """Return the robots that have asked for a dock and not got it, as an extension stores them."""
    return _stored_json(disk, "dock_wait")


def store_rule(disk: Disk, robots: list[str], below: float, idle: float, at: datetime) -> None:
    """Enter a rule that docks idle robots with a low battery, as an extension stores it that has rules.

    Args:
        disk: The database.
        robots: To which it applies.
        below: The charge.
        idle: For how many seconds they have stood idle.
        at: The time.
    """
    selection, condition = {"all": False, "names": robots, "groups": []}, {"below": below, "idle_s": idle}
    rule = {"name": "Low", "mode": "on", "robots": selection, "battery": condition, "schedule": None}
    document = json.dumps(rule | {"changed_by": None, "changed_at": at.isoformat()}).encode()
    with disk.engine.begin() as connection:
        connection.execute(sa.insert(documents), [{"kind": "rule", "key": "low", "document": document}])


def decisions_of_rules(disk: Disk, robot: str) -> list[dict[str, Any]]:
    """Return what rules have decided about a robot, as an extension stores it."""
    return [each for each in _stored_json(disk, "decision").values() if each["robot"] == robot]


def repair_docks(disk: Disk) -> None:
    """Store that all shared docks are in order."""
    records = dock_records(disk)
    with disk.engine.begin() as connection:
        for key, record in records.items():
            mended = record | {"out_of_order_at": None, "note": None, "failures": 0}
            is_it = documents.c.kind == "dock_record", documents.c.key == key
            connection.execute(sa.update(documents).where(*is_it).values(document=json.dumps(mended).encode()))


def share_groups(disk: Disk, groups: dict[str, list[str]]) -> None:
    """Enter the groups that robots are in."""
    of_robots: dict[str, list[str]] = {}
    for group, robots in groups.items():
        for robot in robots:
            of_robots.setdefault(robot, []).append(group)
    labels = {robot: {"display_name": None, "groups": found} for robot, found in of_robots.items()}
    rows = [{"kind": "label", "key": robot, "document": json.dumps(label).encode()} for robot, label in labels.items()]
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
