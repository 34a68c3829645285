"""Traces of goals, which are exported if OpenTelemetry's environment variables say where: docs/extensions/traces.md."""

import logging
import os
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from dock_gateway.core.tasks import closing
from dock_gateway.extension import Extension
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.http.parts import Parts
from dock_gateway.robots.registry import RobotRegistry

if TYPE_CHECKING:
    from dock_gateway.extensions.traces.goal_traces import GoalTraces

log = logging.getLogger(__name__)

ENDPOINTS = ("OTEL_EXPORTER_OTLP_TRACES_ENDPOINT", "OTEL_EXPORTER_OTLP_ENDPOINT")


@asynccontextmanager
async def open_traces(parts: Parts) -> AsyncIterator["GoalTraces | None"]:
    """Export traces if an endpoint is configured. A mistake in the configuration is logged."""
    if (traces := _make_traces(parts)) is None:
        yield None
        return
    async with closing(traces):
        yield traces


def _make_traces(parts: Parts) -> "GoalTraces | None":
    disabled = os.environ.get("OTEL_SDK_DISABLED", "").lower() == "true"
    endpoint = next((os.environ[name] for name in ENDPOINTS if os.environ.get(name)), None)
    if endpoint is None or disabled:
        return None
    try:
        # OpenTelemetry takes 0.2 s and 9 MB.
        from dock_gateway.extensions.traces.goal_traces import GoalTraces, exporting_provider  # noqa: PLC0415

        traces = GoalTraces(exporting_provider(), parts[ActionRegistry], parts[RobotRegistry])
    except ImportError as error:
        log.error("traces are not exported, as dock-gateway[traces] is not installed: %s", error)
        return None
    except Exception:
        log.exception("traces are not exported; check the variables OTEL_…")
        return None
    log.info("exporting traces to %s", endpoint)
    return traces


extension = Extension("traces", open_traces)
