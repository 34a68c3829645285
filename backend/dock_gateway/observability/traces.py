"""Whether traces are exported, as OpenTelemetry's environment variables say (docs/logs.md)."""

import logging
import os
from typing import TYPE_CHECKING

from dock_gateway.http.parts import Parts

if TYPE_CHECKING:
    from dock_gateway.observability.goal_traces import GoalTraces

log = logging.getLogger(__name__)

ENDPOINTS = ("OTEL_EXPORTER_OTLP_TRACES_ENDPOINT", "OTEL_EXPORTER_OTLP_ENDPOINT")


def open_traces(parts: Parts) -> "GoalTraces | None":
    """Begin to export traces if an endpoint is configured. A mistake in the configuration is logged."""
    disabled = os.environ.get("OTEL_SDK_DISABLED", "").lower() == "true"
    endpoint = next((os.environ[name] for name in ENDPOINTS if os.environ.get(name)), None)
    if endpoint is None or disabled:
        return None
    try:
        # OpenTelemetry takes 0.2 s and 9 MB.
        from dock_gateway.observability.goal_traces import GoalTraces, exporting_provider  # noqa: PLC0415

        traces = GoalTraces(exporting_provider(), parts)
    except ImportError as error:
        log.error("traces are not exported, as dock-gateway[traces] is not installed: %s", error)
        return None
    except Exception:
        log.exception("traces are not exported; check the variables OTEL_…")
        return None
    log.info("exporting traces to %s", endpoint)
    return traces
