"""The settings of maps."""

from typing import ClassVar

from pydantic import Field

from dock_gateway.setting_types import Topic
from dock_gateway.settings import ExtensionSettings


class MapSettings(ExtensionSettings):
    """The topics that are shown on a map."""

    group: ClassVar[str] = "Maps"

    map_topic: Topic = Field(
        "map",
        description="Topic of `nav_msgs/OccupancyGrid`, the robot's map; if its robot has none, the one of this name "
        "that all robots share ([maps.md](extensions/maps.md)).",
    )
    scan_topic: Topic = Field("scan", description="Topic of `sensor_msgs/LaserScan`, shown on maps.")
    path_topic: Topic = Field("plan", description="Topic of `nav_msgs/Path`, shown on maps.")
