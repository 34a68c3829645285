"""The black box: what was said on the topics of a robot before and while a goal ran."""

from collections.abc import AsyncIterator, Iterator
from contextlib import ExitStack, asynccontextmanager

from dock_gateway.audit.record import RequestRecord
from dock_gateway.core.tasks import closing
from dock_gateway.extension import Extension
from dock_gateway.extensions.recordings.error_codes import CODES
from dock_gateway.extensions.recordings.recorder import Recorder
from dock_gateway.extensions.recordings.recordings import Recordings
from dock_gateway.extensions.recordings.routes import router
from dock_gateway.extensions.recordings.schema import GoalRecording
from dock_gateway.extensions.recordings.settings import RecordingSettings
from dock_gateway.extensions.recordings.store import RecordingStore
from dock_gateway.fleet.alert import Alert
from dock_gateway.fleet.alert_board import AlertBoard
from dock_gateway.fleet.alert_kinds import AlertKind
from dock_gateway.goals.goal_documents import GoalField
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.graph.relays import Relays
from dock_gateway.http.parts import Parts
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.settings import Settings

RECORDINGS_FAILED = AlertKind("recordings_failed", critical=False)


@asynccontextmanager
async def open_recordings(parts: Parts) -> AsyncIterator[Recordings]:
    """Record goals, from their first sign until they have ended or are lost."""
    gateway, robots = parts[Settings], parts[RobotRegistry]
    settings = gateway.of(RecordingSettings)
    folder = settings.recordings_path or gateway.own_file("recordings")
    store = RecordingStore(folder, settings.recording_retention_mb * 1_000_000, settings.recording_retention_days)
    with parts[AlertBoard].sources.adding(lambda: _trouble(store)):
        if settings.recordings == "none":
            yield Recordings(store, None)
            return
        async with closing(Recorder(gateway, robots.topics.bridge, parts[Relays], robots, store)) as recorder:
            with _following(parts, recorder):
                yield Recordings(store, recorder)


def _following(parts: Parts, recorder: Recorder) -> ExitStack:
    """Let a recorder know of goals, commands and robots until what is returned is closed."""
    actions, robots, following = parts[ActionRegistry], parts[RobotRegistry], ExitStack()
    following.enter_context(actions.on_sent.adding(recorder.follow))
    following.enter_context(actions.on_change.adding(recorder.follow))
    following.enter_context(actions.on_end.adding(recorder.end))
    following.enter_context(actions.on_lost.adding(recorder.end))
    following.enter_context(parts[RequestRecord].on_entry.adding(recorder.on_command))
    following.enter_context(robots.on_scan.adding(recorder.update))
    following.enter_context(robots.before_removal.adding(recorder.leave))
    return following


def _trouble(store: RecordingStore) -> Iterator[Alert]:
    """Yield why recordings cannot be written, if so."""
    if (trouble := store.trouble) is not None:
        yield Alert(RECORDINGS_FAILED, None, trouble.since, "No recordings", trouble.detail)


extension = Extension(
    "recordings",
    open_recordings,
    settings=RecordingSettings,
    routes=lambda _: (router,),
    alerts=(RECORDINGS_FAILED,),
    errors=CODES,
    goal_field=GoalField("recording", GoalRecording, Recordings.describe),
)
