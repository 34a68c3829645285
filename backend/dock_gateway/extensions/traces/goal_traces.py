"""Goals as OpenTelemetry traces: a span for each goal that this gateway sends, from its request to its end.

Only `extension` imports this, and only if traces are exported.
"""

import asyncio
import threading
from contextlib import ExitStack

from opentelemetry.context import Context
from opentelemetry.exporter.otlp.proto.http.trace_exporter import OTLPSpanExporter
from opentelemetry.sdk.resources import OTELResourceDetector, Resource
from opentelemetry.sdk.trace import TracerProvider
from opentelemetry.sdk.trace.export import BatchSpanProcessor
from opentelemetry.trace import Span, Status, StatusCode, Tracer, set_span_in_context
from opentelemetry.trace.propagation.tracecontext import TraceContextTextMapPropagator

from dock_gateway import __version__
from dock_gateway.core.event import nanoseconds
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.core.request import CURRENT
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.robots.registry import RobotRegistry

# Seconds at shutdown for the spans that have not been sent yet. The process has to end within 3 s.
FLUSH_WITHIN = 0.5
FAILED = frozenset({GoalStatus.ABORTED, GoalStatus.REJECTED, GoalStatus.LOST})


def exporting_provider() -> TracerProvider:
    """Return a provider that sends spans by OTLP over HTTP, in a thread; the environment says where.

    Raises:
        ValueError: A variable has an invalid value.
    """
    names = Resource.create({"service.name": "dock-gateway", "service.version": __version__})
    resource = names.merge(OTELResourceDetector().detect())
    provider = TracerProvider(resource=resource, shutdown_on_exit=False)  # `close` has a deadline
    provider.add_span_processor(BatchSpanProcessor(OTLPSpanExporter()))
    return provider


class GoalTraces:
    """The spans of the goals that have not ended.

    Args:
        provider: Exports the spans that have ended.
        goals: Says when one is sent, changes or ends.
        robots: Says whose an action is.
    """

    def __init__(self, provider: TracerProvider, goals: ActionRegistry, robots: RobotRegistry) -> None:
        self._provider = provider
        self._tracer = provider.get_tracer("dock_gateway", __version__)
        self._robots = robots
        self._traces: dict[str, GoalTrace] = {}
        self._listening = ExitStack()
        self._listening.enter_context(goals.on_sent.adding(self._on_sent))
        self._listening.enter_context(goals.on_change.adding(self._on_change))
        self._listening.enter_context(goals.on_end.adding(self._on_end))

    def _on_sent(self, goal: Goal) -> None:
        if goal.goal_id not in self._traces:  # otherwise it is sent again
            robot = self._robots.owner(goal.action_name)
            self._traces[goal.goal_id] = GoalTrace(self._tracer, goal, None if robot is None else robot.namespace)

    def _on_change(self, goal: Goal) -> None:
        if trace := self._traces.get(goal.goal_id):
            trace.update(goal)

    def _on_end(self, goal: Goal) -> None:
        if trace := self._traces.pop(goal.goal_id, None):
            trace.end(goal)

    async def close(self) -> None:
        """End all spans, and send what has not been sent yet, at most for `FLUSH_WITHIN` seconds."""
        self._listening.close()
        for trace in self._traces.values():
            trace.leave()
        self._traces.clear()
        loop, flushed = asyncio.get_running_loop(), asyncio.Event()

        def flush() -> None:
            self._provider.shutdown()
            if not loop.is_closed():
                loop.call_soon_threadsafe(flushed.set)

        # Not a thread of the loop's executor, which would be waited for.
        threading.Thread(target=flush, name="flushing traces", daemon=True).start()
        try:
            async with asyncio.timeout(FLUSH_WITHIN):
                await flushed.wait()
        except TimeoutError:
            return


class GoalTrace:
    """The span of one goal, and that of its submission: from the request until the action server accepts the goal.

    Args:
        tracer: Makes the spans.
        goal: The goal, which is being sent. If its request is part of a trace, the span is, too.
        robot: The namespace of its robot, if it has one.
    """

    def __init__(self, tracer: Tracer, goal: Goal, robot: str | None) -> None:
        request = CURRENT.get() if goal.origin == "gateway" else None
        parent = Context() if request is None else TraceContextTextMapPropagator().extract(request.trace, Context())
        attributes = {
            "goal_id": goal.goal_id,
            "action_name": goal.action_name,
            "robot": robot,
            "verb": goal.verb,
            "origin": goal.origin,
            "request_id": request and request.request_id,
        }
        known = {name: value for name, value in attributes.items() if value is not None}
        began = nanoseconds(goal.updated_at)
        self._span = tracer.start_span("goal", parent, attributes=known, start_time=began)
        self._submit: Span | None = tracer.start_span(
            "submit", set_span_in_context(self._span, Context()), start_time=began
        )
        self._status = goal.status
        self._stage = goal.stage
        self._has_feedback = goal.feedback_count > 0

    def update(self, goal: Goal) -> None:
        """Add an event for what has changed."""
        if goal.status is not self._status:
            self._status = goal.status
            self._span.add_event(goal.status.value)
            if self._submit is not None:
                _end(self._submit, goal)
                self._submit = None
        if goal.stage is not None and goal.stage != self._stage:
            self._stage = goal.stage
            self._span.add_event("stage", {"stage": goal.stage})
        if goal.feedback_count and not self._has_feedback:
            self._has_feedback = True
            self._span.add_event("first feedback")

    def end(self, goal: Goal) -> None:
        """End the span with the goal."""
        self.update(goal)
        if goal.retries is not None:
            self._span.set_attribute("retries", goal.retries)
        _end(self._span, goal)

    def leave(self) -> None:
        """End the span before the goal has ended, as the gateway closes."""
        self._span.add_event("gateway closed")
        self._span.set_attribute("status", self._status.value)
        if self._submit is not None:
            self._submit.end()
        self._span.end()


def _end(span: Span, goal: Goal) -> None:
    span.set_attribute("status", goal.status.value)
    if goal.error is not None:
        span.set_attribute("error_code", goal.error.code)
    if goal.status in FAILED:
        span.set_status(Status(StatusCode.ERROR, None if goal.error is None else goal.error.detail))
    span.end()
