"""A mission as it is stored, with its steps (`step_entry.py`). Plain data; `progress.py` has the rules."""

from collections.abc import Mapping
from datetime import datetime, timedelta
from enum import StrEnum
from typing import Annotated, Any

from pydantic import Field

from dock_gateway.extensions.missions.battery import BatteryLimits
from dock_gateway.extensions.missions.step_entry import Reason, StepEntry
from dock_gateway.extensions.missions.step_kinds import Waypoint
from dock_gateway.http.schema import RosName, Schema

# A step of `GET /missions` has what clients sent, and these.
STORED_ONLY = frozenset({"tried", "retry_at", "size", "sender", "sends_until"})
Priority = Annotated[int, Field(ge=0, le=100)]
# That of a mission that names none.
PRIORITY = 50
# How long a notice is an alert at least.
NOTICE_FOR = timedelta(minutes=1)


class MissionStatus(StrEnum):
    """The states of a mission. Of those of a robot, one at a time is `running`, `held` or `canceling`."""

    QUEUED = "queued"
    RUNNING = "running"
    HELD = "held"
    CANCELING = "canceling"
    SUCCEEDED = "succeeded"
    FAILED = "failed"
    CANCELED = "canceled"

    @property
    def ended(self) -> bool:
        """Whether no other state follows."""
        return self in (MissionStatus.SUCCEEDED, MissionStatus.FAILED, MissionStatus.CANCELED)


class HoldReason(StrEnum):
    """Why a mission does not go on until a person continues it.

    `stop`: the robot was stopped. `canceled`: the goal of its step was canceled, and not by the mission. `lost`:
    nobody knows what the robot did: contact was lost during that goal, and it takes too long, or the gateway ended
    during a call or a message. `person`: its step waits for a person. `paused`: it was paused. `recharge`: its robot
    did not reach its dock, or its charge, or did not leave its dock. `approval`: an agent has asked for it, and no
    person has allowed it yet.
    """

    STOP = "stop"
    CANCELED = "canceled"
    LOST = "lost"
    PERSON = "person"
    PAUSED = "paused"
    RECHARGE = "recharge"
    APPROVAL = "approval"


class Notice(Schema):
    """What a mission has last told people.

    Attributes:
        text: The sentence.
        critical: Whether somebody has to act.
        told_at: When.
        standing: Whether the step after it has not ended.
    """

    text: str
    critical: bool
    told_at: datetime
    standing: bool = True

    def is_active(self, now: datetime) -> bool:
        """Return whether it is an alert now."""
        return self.standing or now < self.told_at + NOTICE_FOR


class RechargeStage(StrEnum):
    """What the robot does during a break for its battery: `undocking` comes before a step that moves it."""

    DOCKING = "docking"
    CHARGING = "charging"
    UNDOCKING = "undocking"


class Recharge(Schema):
    """A break for the battery of the robot, as it is stored.

    Attributes:
        number: Counts the breaks of the mission.
        stage: How far it has come.
        started_at: When it began.
        step: What is carried out now.
        off_since: Since when the battery of the docked robot has been discharging.
    """

    number: int
    stage: RechargeStage
    started_at: datetime
    step: StepEntry
    off_since: datetime | None = None

    def document(self) -> Mapping[str, Any]:
        """Return it as `GET /missions/{mission_id}` shows it."""
        fields = self.model_dump(include={"number", "stage", "started_at"})
        return fields | self.step.model_dump(include={"tried", "goal_id", "error"})


class MissionFields(Schema):
    """The fields of a mission that are stored and shown.

    `priority`: of the missions of a robot that have not begun, the one with the highest begins first, then the one with
    the lowest `order`, which is by age unless one was moved. `battery`: when the robot returns to charge, and until
    when; null: never by the mission's own will. `step` is the index of the present step; once all have ended, their
    number. `wait_at` is where the robot waits for its dock, or is driving to; null: where it is. `pausing`: it will be
    held before its next step. `robot` is null until a robot of the `group` has begun it. `template` is the id of the
    template that it was made of, with which `arguments`, and `schedule` that of the schedule that has queued it; null:
    none.
    """

    robot: RosName | None
    group: str | None = None
    name: str | None
    priority: int
    order: int = 0
    battery: BatteryLimits | None = None
    status: MissionStatus
    held_for: HoldReason | None
    pausing: bool = False
    step: Annotated[int, Field(ge=0)]
    wait_at: Waypoint | None = None
    error: Reason | None
    template: str | None = None
    arguments: dict[str, Any] | None = None
    schedule: str | None = None
    created_by: str | None
    created_at: datetime
    started_at: datetime | None
    finished_at: datetime | None


class MissionEntry(MissionFields):
    """A mission as it is stored.

    Attributes:
        steps: Its steps, at least one.
        notice: What it has last told people; None: nothing.
        asked_battery: What a rule of automatic docking has asked of a mission that says nothing itself.
        by_agent: Whether an agent has asked for it.
        recharge: Its break for the battery; None: it is at its step.
        recharges: How many breaks it has begun.
        drive: The drive to `wait_at`, in place of the step that docks the robot; None: it is not on its way there.
        drives: How many of these it has begun.
        recharge_skipped: Whether it goes on without a break until the battery has been charged.
        parked: Whether a break has left the robot on its dock.
        revision: Counts its changes: one who changes it says what they have read.
        edition: Counts the changes of what it is to do.
        allowed_at: When somebody last let it begin or go on, after it was queued.
    """

    steps: tuple[StepEntry, ...]
    notice: Notice | None = None
    asked_battery: BatteryLimits | None = None
    by_agent: bool = False
    recharge: Recharge | None = None
    recharges: int = 0
    drive: StepEntry | None = None
    drives: int = 0
    recharge_skipped: bool = False
    parked: bool = False
    revision: int = 0
    edition: int = 0
    allowed_at: datetime | None = None

    @property
    def its_robot(self) -> str:
        """The robot that has begun it, or will."""
        if self.robot is None:
            raise AssertionError(f"no robot of {self.group} has begun it")
        return self.robot

    @property
    def allowed_since(self) -> datetime:
        """When somebody last let it begin or go on."""
        return self.allowed_at or self.created_at

    @property
    def etag(self) -> str:
        """The version of what it is to do."""
        return f'"{self.edition}"'

    @property
    def current(self) -> StepEntry:
        """What is carried out now, of a mission that has not ended: its present step, that of its break, or a drive."""
        if self.drive is not None:
            return self.drive
        return self.steps[self.step] if self.recharge is None else self.recharge.step

    @property
    def position(self) -> str:
        """Where it is: tells its present step, its break or its drive from all others."""
        if self.drive is not None:
            return f"drive-{self.drives}"
        return str(self.step) if self.recharge is None else f"recharge-{self.recharge.number}"

    @property
    def driving_to(self) -> Waypoint | None:
        """Where its robot is on its way to, to wait for its dock; None: it is not."""
        return None if self.drive is None else self.wait_at

    @property
    def limits(self) -> BatteryLimits | None:
        """When the robot returns to charge: what the mission says, else what a rule has asked for."""
        return self.battery or self.asked_battery

    @property
    def active(self) -> bool:
        """Whether it has begun and not ended: it has its robot."""
        return self.started_at is not None and not self.status.ended

    @property
    def in_queue(self) -> bool:
        """Whether it has neither begun nor ended."""
        return self.started_at is None and not self.status.ended

    @property
    def turn(self) -> tuple[int, int, datetime]:
        """Sorts the missions that have not begun by whose turn it is."""
        return -self.priority, self.order, self.created_at

    def but(self, **fields: Any) -> "MissionEntry":
        """Return the mission with other fields, as its next revision."""
        return self.model_copy(update={"revision": self.revision + 1, **fields})

    def edited(self, other: "MissionEntry") -> "MissionEntry":
        """Return a mission that has not begun with what a new one is to do, in its place in the queue."""
        asked = {
            name: getattr(other, name) for name in ("name", "priority", "battery", "template", "arguments", "steps")
        }
        return self.but(**asked, edition=self.edition + 1, allowed_at=other.created_at)

    def with_step(self, index: int | None = None, /, **fields: Any) -> "MissionEntry":
        """Return the mission with other fields of a step, by default of the present one, as its next revision."""
        if index is None and self.drive is not None:
            return self.but(drive=self.drive.model_copy(update=fields))
        if index is None and self.recharge is not None:
            step = self.recharge.step.model_copy(update=fields)
            return self.but(recharge=self.recharge.model_copy(update={"step": step}))
        at = self.step if index is None else index
        steps = (*self.steps[:at], self.steps[at].model_copy(update=fields), *self.steps[at + 1 :])
        return self.but(steps=steps)

    def document(self, mission_id: str, waits_for: str | None) -> Mapping[str, Any]:
        """Return it as `GET /missions/{mission_id}` shows it."""
        return {
            "mission_id": mission_id,
            **self.model_dump(include=set(MissionFields.model_fields)),
            "waits_for": waits_for,
            "etag": self.etag,
            "recharge": self.recharge and self.recharge.document(),
            "steps": [step.model_dump(exclude=set(STORED_ONLY)) for step in self.steps],
        }
