"""What is known of a mission's robot, and what may come next for the mission. Plain data."""

from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum

from dock_gateway.core.goal import Goal
from dock_gateway.extensions.missions.mission import MissionEntry
from dock_gateway.extensions.missions.step_entry import Reason
from dock_gateway.extensions.missions.step_kinds import Waypoint


class WaitsFor(StrEnum):
    """What a mission waits for that has not ended."""

    TURN = "turn"
    ROBOT = "robot"
    GROUP = "group"
    CONTINUE = "continue"
    STOP_RELEASED = "stop_released"
    OTHER_GOAL = "other_goal"
    RETRY = "retry"
    TIME = "time"
    BATTERY = "battery"
    GOAL = "goal"
    SERVER = "server"
    DOCK = "dock"
    ANSWER = "answer"
    LOST_GOAL = "lost_goal"
    HISTORY = "history"


@dataclass(frozen=True)
class Sent:
    """How far a call or a message has come at the gateway that sends it.

    Attributes:
        over: Whether it has ended.
        error: Why it has failed.
        by_stop: Whether a stop has kept it from being sent.
    """

    over: bool = False
    error: Reason | None = None
    by_stop: bool = False


@dataclass(frozen=True)
class Facts:
    """What is known of the robot of a mission.

    Attributes:
        stopped: Whether a stop of its robot has come since somebody let it begin or go on.
        latched: Whether a stop of its robot stays.
        other_goal: Whether a goal runs on it that is not this mission's.
        battery: Its charge, 0 to 1; None if that is unknown.
        place: Where the place is that the present step drives to; None if it names none, or there is none.
        charging: Whether its battery says that it is being charged, or is full.
        full: Whether its battery says that it is full.
        discharging: Whether its battery says that it is not being charged, but discharges.
        docked: Whether it is docked; None if that is unknown.
        goal: The goal of the present step, as far as it is known.
        given_up: Whether that is lost, and canceled should it return.
        sent: The call or message of the present step, if this gateway has begun its try; else None.
        gateway: This gateway; None: no other follows the mission.
    """

    stopped: bool = False
    latched: bool = False
    other_goal: bool = False
    battery: float | None = None
    place: Waypoint | None = None
    charging: bool = False
    full: bool = False
    discharging: bool = False
    docked: bool | None = None
    goal: Goal | None = None
    given_up: bool = False
    sent: Sent | None = None
    gateway: str | None = None


@dataclass(frozen=True)
class Change:
    """The mission becomes this one."""

    mission: MissionEntry


@dataclass(frozen=True)
class Send:
    """The goal of the present step is to be sent, or found again; its call or message is to be sent."""


@dataclass(frozen=True)
class Cancel:
    """The goal of the present step is to be canceled."""

    goal: Goal


@dataclass(frozen=True)
class Wait:
    """There is nothing to do until something changes, or until a time."""

    reason: WaitsFor
    until: datetime | None = None


Move = Change | Send | Cancel | Wait
