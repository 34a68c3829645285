"""The settings of access: whether a login is needed, and what those with access may do on the ROS graph."""

from typing import ClassVar

from pydantic import Field

from dock_gateway.setting_groups.group import SettingsGroup
from dock_gateway.setting_types import Patterns, Seconds


class AccessSettings(SettingsGroup):
    """The settings of access: whether a login is needed, and what those with access may do on the ROS graph."""

    group: ClassVar[str] = "Access"

    authentication: bool = Field(
        False,
        description="Whether requests need a login or a token: [access.md](access.md).",
    )
    allow_open: bool = Field(
        False,
        description="Whether the gateway may listen on other than loopback addresses without `authentication`: then "
        "everyone who reaches it can move the robots.",
    )
    approval_timeout: Seconds = Field(
        60.0,
        description="Seconds that an agent's goal to a real robot waits for a person to allow it; then it is refused.",
    )
    allow_publish: Patterns = Field(
        (),
        description="Topics that clients may publish on, separated by commas: `/battery_status`, or `/robot1/*`, where "
        "`*` stands for any text. Empty: none ([graph.md](graph.md)).",
    )
    allow_services: Patterns = Field(
        (),
        description="Services that clients may call, likewise, besides those that only read, such as `get_parameters`. "
        "Name none that may move a robot unless that is meant.",
    )
    allow_parameters: Patterns = Field(
        (), description="Nodes whose parameters supervisors may set, likewise. Everyone may read them."
    )
