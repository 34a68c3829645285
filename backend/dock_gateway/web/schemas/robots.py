"""Schemas of the battery history, for the OpenAPI document only."""

from datetime import datetime

from dock_gateway.web.schemas.goals import Schema


class Measured(Schema):
    """The mean, minimum and maximum of a field in each bucket; null if it was not measured."""

    mean: list[float | None]
    min: list[float | None]
    max: list[float | None]


class BatteryHistory(Schema):
    """Columns of equal length, one row per bucket that has messages. `time` is that of the bucket's last message."""

    robot: str
    since: datetime
    until: datetime
    resolution_s: float
    time: list[datetime]
    voltage: Measured
    percentage: Measured
    current: Measured
    temperature: Measured
    power_supply_status: list[int]
