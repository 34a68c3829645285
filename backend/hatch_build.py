"""Puts the built dashboard into the wheel, where there is one.

An editable installation serves `frontend/dist` from the checkout and needs no copy.
"""

from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class DashboardBuildHook(BuildHookInterface):
    """Adds `frontend/dist` to the wheel as `dock_gateway/dashboard`."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Called by hatchling before a build."""
        dist = Path(self.root) / "frontend" / "dist"
        if version != "editable" and dist.is_dir():
            build_data["force_include"][str(dist)] = "dock_gateway/dashboard"
