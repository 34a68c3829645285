"""Traces are exported only if OpenTelemetry's variables say so, and a mistake in them stops nothing."""

import builtins
import subprocess
import sys
from types import SimpleNamespace
from typing import Any

import pytest

from dock_gateway.core.listeners import Hooks
from dock_gateway.extensions.traces.extension import open_traces
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.http.parts import Parts
from dock_gateway.robots.registry import RobotRegistry

ENDPOINT = "OTEL_EXPORTER_OTLP_ENDPOINT"


@pytest.fixture
def parts() -> Parts:
    actions = SimpleNamespace(**{name: Hooks[object]() for name in ("on_sent", "on_change", "on_end")})
    return Parts({ActionRegistry: actions, RobotRegistry: None})


def test_without_an_endpoint_nothing_is_imported() -> None:
    # FastAPI imports `opentelemetry.trace`, which is small.
    program = (
        "import sys; from dock_gateway.extension import extensions; extensions(); "
        "print({'opentelemetry.sdk'} & sys.modules.keys())"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


async def test_without_an_endpoint_there_are_none(parts: Parts) -> None:
    async with open_traces(parts) as traces:
        assert traces is None
        assert not parts[ActionRegistry].on_sent


async def test_they_can_be_disabled(parts: Parts, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(ENDPOINT, "http://127.0.0.1:9")
    monkeypatch.setenv("OTEL_SDK_DISABLED", "true")
    async with open_traces(parts) as traces:
        assert traces is None


@pytest.mark.parametrize("variable", [ENDPOINT, "OTEL_EXPORTER_OTLP_TRACES_ENDPOINT"])
async def test_with_an_endpoint(parts: Parts, monkeypatch: pytest.MonkeyPatch, variable: str) -> None:
    monkeypatch.setenv(variable, "http://127.0.0.1:9")
    async with open_traces(parts) as traces:
        assert traces is not None
        assert parts[ActionRegistry].on_sent
    assert not parts[ActionRegistry].on_sent


async def test_a_package_that_is_missing(
    parts: Parts, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    importing = builtins.__import__

    def fails(name: str, *args: Any, **kwargs: Any) -> Any:
        if name.endswith("goal_traces"):
            raise ModuleNotFoundError("No module named 'opentelemetry'")
        return importing(name, *args, **kwargs)

    monkeypatch.setenv(ENDPOINT, "http://127.0.0.1:9")
    monkeypatch.setattr(builtins, "__import__", fails)
    async with open_traces(parts) as traces:
        assert traces is None
    assert "dock-gateway[traces] is not installed" in caplog.text


async def test_a_wrong_variable(
    parts: Parts, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv(ENDPOINT, "http://127.0.0.1:9")
    monkeypatch.setenv("OTEL_BSP_SCHEDULE_DELAY", "-1")
    async with open_traces(parts) as traces:
        assert traces is None
    assert "check the variables OTEL_" in caplog.text
