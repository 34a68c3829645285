"""The parameters of the undocking action server."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from docking.core.parameter import Meanings, Value, group, switch
from docking.parameters.dock import Staging
from docking.parameters.nav2 import read_nav2_for_undocking
from docking.parameters.server import ServerSettings
from docking.parameters.timeouts import UndockTimeouts


@dataclass(frozen=True)
class UndockSettings(ServerSettings):
    """The parameters of the undocking action server."""

    timeouts: UndockTimeouts = group(UndockTimeouts)
    assume_docked: bool = switch(
        False,
        "Whether a robot backs out although nothing tells that it is docked: for bases whose battery never tells that "
        "it charges. If it is false, the goal is aborted (DOCKED_UNKNOWN).",
    )
    staging: Staging = group(Staging)

    @classmethod
    def read_given(cls, given: Mapping[str, Value], resolve: Callable[[str], str]) -> Meanings:
        """Return the meaning of given parameters of nav2's docking server."""
        return read_nav2_for_undocking(given, resolve)

    def find_conflict(self) -> str | None:
        """Return why these values cannot work together."""
        return super().find_conflict() or self.find_backing_shortage(
            "undocking_timeout", self.timeouts.undocking_timeout, self.staging.distance
        )
