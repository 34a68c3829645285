"""The metrics of shared docks."""

from collections.abc import Iterator

from prometheus_client import Metric

from dock_gateway.extensions.chargers.board import DockBoard
from dock_gateway.observability.collector import gauge, gauges


def dock_metrics(board: DockBoard) -> Iterator[Metric]:
    """Yield how many docks are in which state, and how many robots wait."""
    states, waiting = board.counts()
    yield gauges("shared_docks", "Shared docks by their state", "state", states)
    yield gauge("shared_docks_waiting", "Robots that wait for a shared dock", waiting)
