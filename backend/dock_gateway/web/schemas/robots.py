"""The shape of the battery's history; as in `schemas`, for types alone."""

from datetime import datetime

from dock_gateway.web.schemas.goals import Schema


class Measured(Schema):
    """What was measured of a field in each bucket; null where it was not."""

    mean: list[float | None]
    min: list[float | None]
    max: list[float | None]


class BatteryHistory(Schema):
    """Columns of equal length, a row for each bucket in which there was a message; `time` is that of its last one."""

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
