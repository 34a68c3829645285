"""The black box: what was said on the topics of a robot before and while a goal ran."""

from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager

from dock_gateway.core.tasks import closing
from dock_gateway.extension import Extension, GatewayCore
from dock_gateway.extensions.recordings.recorder import Recorder
from dock_gateway.extensions.recordings.recordings import Recordings
from dock_gateway.extensions.recordings.routes import router
from dock_gateway.extensions.recordings.settings import RecordingSettings
from dock_gateway.extensions.recordings.store import RecordingStore
from dock_gateway.fleet.alert import Alert
from dock_gateway.fleet.alert_kinds import AlertKind

RECORDINGS_FAILED = AlertKind("recordings_failed", critical=False)


@asynccontextmanager
async def open_recordings(core: GatewayCore) -> AsyncIterator[Recordings]:
    """Record goals, from their first sign until they have ended or are lost."""
    settings = core.settings.of(RecordingSettings)
    folder = settings.recordings_path or core.settings.own_file("recordings")
    store = RecordingStore(folder, settings.recordings_mb * 1_000_000, settings.recordings_days)
    core.alerts.sources.append(lambda: _trouble(store))
    if settings.record == "none":
        yield Recordings(store, None)
        return
    bridge = core.robots.topics.bridge
    async with closing(Recorder(core.settings, bridge, core.topics, core.robots, store)) as recorder:
        _follow(core, recorder)
        yield Recordings(store, recorder)


def _follow(core: GatewayCore, recorder: Recorder) -> None:
    goals = core.goals
    goals.on_sent.append(recorder.follow)
    goals.on_change.append(recorder.follow)
    goals.on_end.append(recorder.end)
    goals.on_lost.append(recorder.end)
    core.requests.on_entry.append(recorder.on_command)
    core.robots.on_scan.append(recorder.update)
    core.robots.before_removal.append(recorder.leave)


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
)
