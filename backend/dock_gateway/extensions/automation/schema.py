"""What the API returns about automatic docking: rules and decisions."""

from datetime import datetime
from typing import Literal

from pydantic import ConfigDict

from dock_gateway.extensions.automation.decision import DecisionFields, WaitReason
from dock_gateway.extensions.automation.rule import RuleEntry
from dock_gateway.http.resource import Versioned
from dock_gateway.http.schema import Identified, Schema
from dock_gateway.streams.schema import FleetEvent


class RuleRobot(Schema):
    """A robot that a rule applies to now, and why it is not docked now."""

    robot: str
    waits_for: WaitReason


class Rule(RuleEntry, Versioned):
    """A rule of automatic docking. Either `battery` or `schedule` is null.

    `applies_to` lists the robots on the gateway that it applies to.
    """

    id: str
    applies_to: list[RuleRobot]


class RuleList(Schema):
    """The rules, by name."""

    rules: list[Rule]


class Decision(DecisionFields, Identified):
    """What a rule decided about a robot, and the facts that it went by.

    `battery` is the charge (0 to 1); `idle_since_at` is when the robot was idle with a low battery, or stood still
    before a time of day, which is `scheduled_at`. `code` and `detail` say why no goal was sent.
    """

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "id": "0b8f9b0e4e5c4c62a2ac3c2f5bd0a1f2",
                    "rule_id": "low-battery",
                    "rule_name": "Low battery",
                    "robot": "/robot1",
                    "decided_at": "2026-11-21T21:04:12.182Z",
                    "outcome": "sent",
                    "battery": 0.18,
                    "idle_since_at": "2026-11-21T21:03:12.182Z",
                    "scheduled_at": None,
                    "goal_id": "6a8c2b0a-5c63-4d0e-9c1e-0d7a9c4d5e6f",
                    "code": None,
                    "detail": None,
                }
            ]
        }
    )


class DecisionList(Schema):
    """A page of decisions, newest first. `next_cursor` leads to older ones; null: there are none."""

    decisions: list[Decision]
    next_cursor: str | None


class Hold(Schema):
    """A robot that was stopped: its automatic docking waits until a person continues it.

    `held_at` is when it was stopped, or its stop was released.
    """

    held_at: datetime
    robot: str


class HoldList(Schema):
    """The robots that were stopped, by name."""

    holds: list[Hold]


class AutomationEvent(FleetEvent):
    """A rule of automatic docking has decided, at any gateway that shares the history."""

    type: Literal["automation"]
    time: datetime
    automation: Decision


# What streams can ask for.
EVENTS = (AutomationEvent,)
