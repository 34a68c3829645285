"""The settings of single robots: a table for each in the configuration file, as in `[robots."/robot1"]`."""

import json
from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field
from pydantic_settings import NoDecode

from dock_gateway.setting_types import ROBOTS, OptionalTopic

# What a pattern cannot have: each robot has its own.
OF_ONE = ("dock_action", "undock_action")


class _Table(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class BatteryTable(_Table):
    """The battery of a robot: its topic, and what its driver means."""

    topic: OptionalTopic = Field("", description="Topic of `sensor_msgs/BatteryState`.")
    percentage: Literal["0-1", "0-100"] | None = Field(
        None, description="How the driver counts `percentage`. Without it: `0-1`."
    )
    charging_current: Literal["positive", "negative"] | None = Field(
        None,
        description="The sign of a charging `current`; it counts where `power_supply_status` is UNKNOWN. Without it: "
        "`positive`.",
    )


class RobotTable(_Table):
    """What a robot has of its own. Names are relative to its namespace, or absolute."""

    dock_action: OptionalTopic = Field("", description="The action behind `/dock`.")
    undock_action: OptionalTopic = Field("", description="The action behind `/undock`.")
    default_dock: str = Field("", max_length=200, description="The dock that a `POST /dock` without `dock_id` means.")
    battery: BatteryTable = BatteryTable()


def _read_json(value: object) -> object:
    if not isinstance(value, str):
        return value
    try:
        return json.loads(value or "{}")
    except json.JSONDecodeError as error:
        raise ValueError(f'write JSON such as {{"/robot1": {{"default_dock": "lab"}}}}: {error}') from None


def _check(tables: Mapping[str, RobotTable]) -> dict[str, RobotTable]:
    """Return the tables by absolute namespaces, with absolute names."""
    found: dict[str, RobotTable] = {}
    for written, table in tables.items():
        name = f"/{written.strip('/')}"
        if not ROBOTS.fullmatch(written) or name in found:
            raise ValueError(f"{written[:100]!r} is not one namespace such as /robot1, or a pattern such as /hall_a/*")
        if "*" in name and (table.battery.topic or any(getattr(table, field) for field in OF_ONE)):
            raise ValueError(f"{written} stands for several robots, each with actions and a battery topic of its own")
        found[name] = _absolute(name, table)
    for names in (
        *([getattr(table, field) for table in found.values()] for field in OF_ONE),
        [table.battery.topic for table in found.values()],
    ):
        given = [name for name in names if name]
        if len(set(given)) < len(given):
            raise ValueError("no two robots have the same action or battery topic")
    return found


def _absolute(robot: str, table: RobotTable) -> RobotTable:
    def resolve(name: str) -> str:
        return name if not name or name.startswith("/") else f"{robot.rstrip('/')}/{name}"

    names = {field: resolve(getattr(table, field)) for field in OF_ONE}
    return table.model_copy(
        update={**names, "battery": table.battery.model_copy(update={"topic": resolve(table.battery.topic)})}
    )


RobotTables = Annotated[dict[str, RobotTable], NoDecode, BeforeValidator(_read_json), AfterValidator(_check)]


def describe_table(robot: str, **values: Any) -> list[str]:
    """Return the lines of a configuration file that set something of a robot.

    Args:
        robot: Its namespace.
        values: Keys of its table, with `__` for a dot, and their values.
    """
    return [
        f"robots.{json.dumps(robot)}.{key.replace('__', '.')} = {json.dumps(value, ensure_ascii=False)}"
        for key, value in values.items()
        if value is not None
    ]
