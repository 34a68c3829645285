"""The folder with the recordings. A file's name says whose it is: no list beside it can differ from what is there."""

import fcntl
import logging
import os
import re
import shutil
import time
from collections import OrderedDict
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from stat import S_ISREG

from dock_gateway.core.event import utc_now
from dock_gateway.extensions.recordings.mcap_file import McapFile
from dock_gateway.extensions.recordings.topics import CAMERA
from dock_gateway.storage import Incident
from robot_io.recording import Sample, read, read_last

log = logging.getLogger(__name__)

# Bytes on the disk that recordings leave to others, such as the history.
RESERVE = 200_000_000
# Seconds between two log lines about the same trouble.
QUIET = 600.0
# Goals for which the reason why they have no recording is remembered.
MAX_REASONS = 1000
# Messages that are copied at once.
BATCH = 500
_FINISHED = re.compile(r"(?P<goal>[0-9a-f-]{36})\.(?P<kind>failed|succeeded)\.mcap")
PART = ".part"


@dataclass(frozen=True)
class Recording:
    """A finished recording.

    Attributes:
        goal_id: Its goal.
        failed: Whether the goal did not succeed; also if its end is not known.
        path: The file.
        size: In bytes.
        at: When it was finished, in seconds since 1970.
    """

    goal_id: str
    failed: bool
    path: Path
    size: int
    at: float


class NoRoomError(OSError):
    """The disk is as good as full."""


class RecordingStore:
    """The finished recordings, and those that are being written. Its methods read and write files: call it in a thread.

    Args:
        folder: Where they are. Each gateway has its own.
        max_bytes: The maximum size of all. Those of goals that succeeded are deleted first, the oldest first.
        max_days: The maximum age.
        reserve: See `RESERVE`.

    Attributes:
        trouble: Why nothing can be written, and since when; None if all is well.
    """

    def __init__(self, folder: Path, max_bytes: int, max_days: float, reserve: int = RESERVE) -> None:
        self.trouble: Incident | None = None
        self._folder = folder
        self._max_bytes = max_bytes
        self._max_days = max_days
        self._reserve = reserve
        self._reasons: OrderedDict[str, str] = OrderedDict()
        self._complained_at = float("-inf")

    def find(self, goal_id: str) -> Recording | None:
        """Return the recording of a goal."""
        for kind in ("failed", "succeeded"):
            with suppress(OSError):
                return _recording(self._folder / f"{goal_id}.{kind}.mcap")
        return None

    def all(self) -> list[Recording]:
        """Return all finished recordings."""
        found = []
        for path in self._folder.glob("*.mcap"):
            with suppress(OSError):
                if (recording := _recording(path)) is not None:
                    found.append(recording)
        return found

    def why_none(self, goal_id: str) -> str | None:
        """Return why a goal has no recording, if that is known: then there is none."""
        return self._reasons.get(goal_id)

    def note(self, goal_id: str, reason: str) -> None:
        """Note why a goal has no recording."""
        self._reasons[goal_id] = reason
        if len(self._reasons) > MAX_REASONS:
            self._reasons.popitem(last=False)

    def last_picture(self, recording: Recording) -> Sample | None:
        """Return the last message of a camera in a recording.

        Raises:
            OSError: It has been deleted.
        """
        return read_last(recording.path, CAMERA)

    def open(self, goal_id: str) -> "OpenRecording":
        """Begin a recording. What there is of the same goal, as after a restart, becomes its beginning.

        Raises:
            BlockingIOError: Another gateway on this machine records the goal in the same folder.
            OSError: The disk does not take it.
        """
        self.require_room()
        part = self._folder / f"{goal_id}{PART}"
        earlier = self.find(goal_id)
        opened = OpenRecording(part)
        if earlier is not None:
            _copy(earlier.path, opened.file)
        return opened

    def require_room(self) -> None:
        """Make the folder, and see to it that there is room for recordings.

        Raises:
            NoRoomError: There is not.
            OSError: The folder cannot be used.
        """
        self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        free = shutil.disk_usage(self._folder).free
        if free < self._reserve:
            raise NoRoomError(f"only {free // 1_000_000} MB are free, and {self._reserve // 1_000_000} MB stay free")

    def complain(self, error: OSError) -> None:
        """Note trouble with the disk, and log it now and then."""
        detail = f"Recordings cannot be written to {self._folder}: {error.strerror or error}"
        self.trouble = Incident(utc_now() if self.trouble is None else self.trouble.since, detail)
        if time.monotonic() - self._complained_at > QUIET:
            self._complained_at = time.monotonic()
            log.warning("%s", detail)

    def finish(self, opened: "OpenRecording", goal_id: str, about: Mapping[str, str], *, failed: bool) -> None:
        """Finish a recording, in place of an earlier one of the same goal.

        Raises:
            OSError: The disk does not take it.
        """
        opened.finish(about)
        self._place(opened.part, goal_id, failed=failed)
        self._reasons.pop(goal_id, None)  # why there was none until now

    def _place(self, part: Path, goal_id: str, *, failed: bool) -> None:
        kind, other = ("failed", "succeeded") if failed else ("succeeded", "failed")
        part.replace(self._folder / f"{goal_id}.{kind}.mcap")
        (self._folder / f"{goal_id}.{other}.mcap").unlink(missing_ok=True)

    def forget(self, opened: "OpenRecording", goal_id: str, reason: str) -> None:
        """Drop a recording, and an earlier one of the same goal."""
        opened.drop()
        if (earlier := self.find(goal_id)) is not None:
            earlier.path.unlink(missing_ok=True)
        self.note(goal_id, reason)

    def recover(self) -> None:
        """Finish the recordings that an earlier process left when it was killed."""
        for part in self._folder.glob(f"*{PART}"):
            try:
                with part.open("r+b") as left:
                    fcntl.flock(left, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    self._repair(part)
            except (FileNotFoundError, BlockingIOError):  # another gateway is at it
                continue
            except OSError as error:
                self.complain(error)
            except Exception:
                log.exception("while finishing %s, which a killed gateway left", part)

    def _repair(self, part: Path) -> None:
        goal_id = part.name.removesuffix(PART)
        repaired = OpenRecording(part.with_suffix(".repaired"))
        try:
            _copy(part, repaired.file)
            repaired.finish({"goal_id": goal_id, "recovered": "true"})
            self._place(repaired.part, goal_id, failed=True)
        except BaseException:
            repaired.drop()
            raise
        part.unlink(missing_ok=True)
        log.info("finished the recording of goal %s, which a killed gateway left", goal_id)

    def clean(self) -> None:
        """Delete the recordings that are too old or too many: those of goals that succeeded first.

        Then see whether the disk takes more.
        """
        recordings = self.all()
        oldest = time.time() - 86400 * self._max_days
        size = sum(each.size for each in recordings)
        for each in sorted(recordings, key=lambda each: (each.failed, each.at)):
            if each.at < oldest or size > self._max_bytes:
                with suppress(OSError):
                    each.path.unlink(missing_ok=True)
                size -= each.size
                self.note(each.goal_id, "It was deleted, as there were newer ones, or as it was too old.")
        if self.trouble is not None:
            with suppress(OSError):
                self.require_room()
                self.trouble = None


class OpenRecording:
    """A recording that is being written.

    Args:
        part: Its file until it is finished. It is locked: another gateway of this machine may have the same folder.

    Raises:
        BlockingIOError: Another gateway writes it.
        OSError: The disk does not take it.
    """

    def __init__(self, part: Path) -> None:
        self.part = part
        self._output = os.fdopen(os.open(part, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW, 0o600), "r+b")
        try:
            fcntl.flock(self._output, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self._output.truncate()
            self.file = McapFile(self._output)
        except BaseException:
            self._output.close()
            raise

    @property
    def size(self) -> int:
        """Bytes written so far."""
        return self._output.tell()

    def finish(self, about: Mapping[str, str]) -> None:
        """Write the index, and close the file.

        Raises:
            OSError: The disk does not take it.
        """
        self.file.finish(about)
        self.close()

    def close(self) -> None:
        """Close the file as it is; `RecordingStore.recover` finishes it."""
        self._output.close()

    def drop(self) -> None:
        """Close the file, and delete it."""
        with suppress(OSError):
            self.close()
        with suppress(OSError):
            self.part.unlink(missing_ok=True)


def _recording(path: Path) -> Recording | None:
    if (named := _FINISHED.fullmatch(path.name)) is None:
        return None
    stat = path.lstat()
    if not S_ISREG(stat.st_mode):  # a link could lead to any file
        return None
    return Recording(named["goal"], named["kind"] == "failed", path, stat.st_size, stat.st_mtime)


def _copy(source: Path, target: McapFile) -> None:
    batch: list[Sample] = []
    for sample in read(source):
        batch.append(sample)
        if len(batch) >= BATCH:
            target.write(batch)
            batch.clear()
    target.write(batch)
