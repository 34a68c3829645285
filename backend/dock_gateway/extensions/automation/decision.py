"""A decision of automatic docking, why a rule does not dock a robot, and a hold. A new field is declared here alone."""

from datetime import datetime
from enum import StrEnum

from pydantic import ConfigDict

from dock_gateway.http.schema import Schema


class RuleMode(StrEnum):
    """The mode of a rule whose condition is met: do nothing, record what it would do, or dock the robot."""

    OFF = "off"
    DRY_RUN = "dry_run"
    ON = "on"


class DecisionOutcome(StrEnum):
    """The outcome of a decision.

    `sending` becomes another one within seconds, or a minute later if the gateway ended meanwhile.
    """

    DRY_RUN = "dry_run"
    SENDING = "sending"
    SENT = "sent"
    HELD = "held"
    REFUSED = "refused"
    SKIPPED = "skipped"
    GAVE_UP = "gave_up"


# The outcomes of attempts to dock a robot.
ATTEMPTS = frozenset({DecisionOutcome.SENDING, DecisionOutcome.SENT, DecisionOutcome.REFUSED})


class DecisionFields(Schema):
    """One decision of a rule about a robot.

    Attributes:
        rule_id: The rule.
        rule_name: Its name at that time.
        robot: The namespace of the robot.
        decided_at: When it was made.
        outcome: Its outcome.
        battery: The charge that it went by (0 to 1), if measured.
        idle_since_at: Since when the robot was idle, and its battery low if that is the condition.
        scheduled_at: The time of day that it went by, if that is the condition.
        goal_id: The goal, if one was made.
        code: Why no goal was sent, if none was.
        detail: The same, in words.
    """

    model_config = ConfigDict(frozen=True)

    rule_id: str
    rule_name: str
    robot: str
    decided_at: datetime
    outcome: DecisionOutcome
    battery: float | None
    idle_since_at: datetime | None
    scheduled_at: datetime | None
    goal_id: str | None
    code: str | None
    detail: str | None


class DecisionEntry(DecisionFields):
    """A decision as it is stored.

    Attributes:
        open: Whether it counts for later decisions about this low battery.
    """

    open: bool


class WaitReason(StrEnum):
    """Why a rule does not dock a robot now."""

    OFF = "off"
    BATTERY_OK = "battery_ok"
    BATTERY_UNKNOWN = "battery_unknown"
    NOT_DUE = "not_due"
    DOCKED = "docked"
    SERVER_UNAVAILABLE = "server_unavailable"
    SHARED_ACTION = "shared_action"
    GOAL_RUNNING = "goal_running"
    GOAL_LOST = "goal_lost"
    AT_WORK = "at_work"
    DOCK_OCCUPIED = "dock_occupied"
    QUIET_PERIOD = "quiet_period"
    STOPPED = "stopped"
    NOT_IDLE = "not_idle"
    RETRY_LATER = "retry_later"
    REPORTED = "reported"
    STOP_LATCHED = "stop_latched"
    GAVE_UP = "gave_up"
    DECIDING = "deciding"
    HISTORY_UNAVAILABLE = "history_unavailable"
