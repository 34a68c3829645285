"""Puts the built dashboard, where there is one, and the sources of the docking actions into the wheel.

An editable installation takes both from the checkout and needs no copy.
"""

from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class FilesBuildHook(BuildHookInterface):
    """Adds `frontend/dist` to the wheel as `dock_gateway/dashboard`, and what a sourced ROS compiles to `robot_io`."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Called by hatchling before a build."""
        if version == "editable":
            return
        dist = Path(self.root) / "frontend" / "dist"
        if dist.is_dir():
            build_data["force_include"][str(dist)] = "dock_gateway/dashboard"
        for name in ("CMakeLists.txt", "package.xml", "action"):
            source = Path(self.root) / "backend/action_tutorials_interfaces" / name
            build_data["force_include"][str(source)] = f"robot_io/action_tutorials_interfaces/{name}"
