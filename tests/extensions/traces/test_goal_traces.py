"""What is in the trace of a goal, whatever becomes of it."""

import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from types import SimpleNamespace

import pytest
from opentelemetry.sdk.trace import ReadableSpan, TracerProvider
from opentelemetry.sdk.trace.export import BatchSpanProcessor, SimpleSpanProcessor, SpanExporter, SpanExportResult
from opentelemetry.sdk.trace.export.in_memory_span_exporter import InMemorySpanExporter
from opentelemetry.trace import StatusCode

from dock_gateway.core.goal import Goal, GoalError, GoalStatus, Origin
from dock_gateway.core.listeners import Listeners
from dock_gateway.core.request import CURRENT, RequestContext
from dock_gateway.extensions.traces.goal_traces import FLUSH_WITHIN, GoalTraces

NOON = datetime(2026, 1, 1, 12, tzinfo=UTC)
DOCK = "/robot1/connect_to_charging_dock"
TRACE_ID, PARENT_ID = "0af7651916cd43dd8448eb211c80319c", "b7ad6b7169203331"
TRACEPARENT = {"traceparent": f"00-{TRACE_ID}-{PARENT_ID}-01"}


class Scene:
    """Goals of `/robot1`, and the spans that are exported."""

    def __init__(self, exporter: SpanExporter | None = None) -> None:
        self.exporter = InMemorySpanExporter()
        provider = TracerProvider(shutdown_on_exit=False)
        provider.add_span_processor(
            SimpleSpanProcessor(self.exporter) if exporter is None else BatchSpanProcessor(exporter)
        )
        robot = SimpleNamespace(namespace="/robot1")
        self.actions = SimpleNamespace(**{name: Listeners[[Goal]](name) for name in ("on_sent", "on_change", "on_end")})
        robots = SimpleNamespace(owner=lambda name: robot if name.startswith("/robot1/") else None)
        self.traces = GoalTraces(provider, self.actions, robots)  # type: ignore[arg-type]

    def send(self, action: str = DOCK, origin: Origin = "gateway") -> Goal:
        goal = Goal("g-1", action, "pkg/action/Any", NOON, origin, "dock" if action == DOCK else None)
        self.actions.on_sent(goal)
        return goal

    def move(self, goal: Goal, *statuses: GoalStatus) -> None:
        for status in statuses:
            goal.advance(status, NOON + timedelta(seconds=1))
            self.changed(goal)

    def changed(self, goal: Goal) -> None:
        self.actions.on_change(goal)

    def end(self, goal: Goal, status: GoalStatus, error: GoalError | None = None) -> None:
        goal.advance(status, NOON + timedelta(seconds=30))
        goal.error = error
        self.actions.on_end(goal)

    def span(self, name: str) -> ReadableSpan:
        (span,) = (span for span in self.exporter.get_finished_spans() if span.name == name)
        return span

    def events(self) -> list[str]:
        return [event.name for event in self.span("goal").events]


@pytest.fixture
def scene() -> Scene:
    return Scene()


@contextmanager
def request(trace: dict[str, str]) -> Iterator[None]:
    token = CURRENT.set(RequestContext("r-1", trace))
    yield
    CURRENT.reset(token)


def test_a_goal_that_succeeds(scene: Scene) -> None:
    with request({}):
        goal = scene.send()
    scene.move(goal, GoalStatus.ACCEPTED, GoalStatus.EXECUTING)
    for number in range(3):
        goal.hear(b"{}", NOON)
        if not number:
            scene.changed(goal)
    goal.progress("approach", 1, NOON)
    scene.changed(goal)
    scene.end(goal, GoalStatus.SUCCEEDED)
    span, submit = scene.span("goal"), scene.span("submit")
    assert span.attributes == {
        "goal_id": "g-1",
        "action_name": DOCK,
        "robot": "/robot1",
        "verb": "dock",
        "origin": "gateway",
        "request_id": "r-1",
        "status": "succeeded",
        "retries": 1,
    }
    assert scene.events() == ["accepted", "executing", "first feedback", "stage", "succeeded"]
    assert span.parent is None
    assert span.status.status_code is StatusCode.UNSET
    assert submit.parent is not None
    assert submit.parent.span_id == span.get_span_context().span_id
    assert submit.attributes == {"status": "accepted"}
    assert span.start_time == submit.start_time == NOON.timestamp() * 1e9


def test_a_goal_continues_the_trace_of_its_request(scene: Scene) -> None:
    with request(TRACEPARENT):
        goal = scene.send()
    scene.end(goal, GoalStatus.SUCCEEDED)
    parent = scene.span("goal").parent
    assert parent is not None
    assert (f"{parent.trace_id:032x}", f"{parent.span_id:016x}") == (TRACE_ID, PARENT_ID)


@pytest.mark.parametrize("text", ["", "nonsense", "00-0-0-01", f"00-{TRACE_ID}-{PARENT_ID}"])
def test_a_wrong_traceparent_counts_as_none(scene: Scene, text: str) -> None:
    with request({"traceparent": text}):
        goal = scene.send()
    scene.end(goal, GoalStatus.SUCCEEDED)
    assert scene.span("goal").parent is None


def test_a_goal_of_automatic_docking_is_no_part_of_a_request(scene: Scene) -> None:
    with request(TRACEPARENT):
        goal = scene.send(origin="automation")
    scene.end(goal, GoalStatus.SUCCEEDED)
    assert scene.span("goal").parent is None
    assert "request_id" not in (scene.span("goal").attributes or {})


@pytest.mark.parametrize("status", [GoalStatus.REJECTED, GoalStatus.ABORTED, GoalStatus.LOST])
def test_a_goal_that_fails(scene: Scene, status: GoalStatus) -> None:
    goal = scene.send("/fibonacci")
    scene.end(goal, status, GoalError("the_code", "the detail"))
    for span in (scene.span("goal"), scene.span("submit")):
        assert span.attributes is not None
        assert span.attributes["status"] == status.value
        assert span.attributes["error_code"] == "the_code"
        assert (span.status.status_code, span.status.description) == (StatusCode.ERROR, "the detail")
    assert "robot" not in (scene.span("goal").attributes or {})


def test_a_goal_that_is_canceled_has_not_failed(scene: Scene) -> None:
    goal = scene.send()
    scene.move(goal, GoalStatus.EXECUTING, GoalStatus.CANCELING)
    scene.end(goal, GoalStatus.CANCELED)
    assert scene.events() == ["executing", "canceling", "canceled"]
    assert scene.span("goal").status.status_code is StatusCode.UNSET


def test_a_lost_goal_that_is_sent_again_stays_one_trace(scene: Scene) -> None:
    goal = scene.send()
    scene.move(goal, GoalStatus.LOST, GoalStatus.PENDING)
    for listener in scene.actions.on_sent:
        listener(goal)
    scene.move(goal, GoalStatus.ACCEPTED)
    scene.end(goal, GoalStatus.SUCCEEDED)
    assert scene.events() == ["lost", "pending", "accepted", "succeeded"]


def test_goals_of_others_have_no_trace(scene: Scene) -> None:
    goal = Goal("g-2", DOCK, "pkg/action/Any", NOON, "external")
    scene.move(goal, GoalStatus.EXECUTING)
    scene.end(goal, GoalStatus.SUCCEEDED)
    assert not scene.exporter.get_finished_spans()


async def test_goals_that_run_when_the_gateway_closes(scene: Scene) -> None:
    goal = scene.send()
    scene.move(goal, GoalStatus.EXECUTING)
    await scene.traces.close()
    assert scene.events() == ["executing", "gateway closed"]
    assert (scene.span("goal").attributes or {})["status"] == "executing"
    scene.end(goal, GoalStatus.SUCCEEDED)


class HangingExporter(SpanExporter):
    """Never answers."""

    def __init__(self) -> None:
        self.asked = threading.Event()
        self.release = threading.Event()

    def export(self, spans: Sequence[ReadableSpan]) -> SpanExportResult:
        self.asked.set()
        self.release.wait()
        return SpanExportResult.FAILURE


async def test_an_exporter_that_hangs_is_not_waited_for() -> None:
    exporter = HangingExporter()
    scene = Scene(exporter)
    scene.send()
    began = time.monotonic()
    await scene.traces.close()
    assert time.monotonic() - began >= FLUSH_WITHIN
    assert exporter.asked.is_set()
    exporter.release.set()
