"""The rules of automatic docking, as people see and change them, each with what it waits for."""

import logging
from collections.abc import Collection, Iterable
from typing import Any

from dock_gateway.core.event import utc_now
from dock_gateway.core.grant import UNLIMITED, Grant
from dock_gateway.core.versions import UNCONDITIONAL, Condition
from dock_gateway.extensions.automation.decision import RuleMode, WaitReason
from dock_gateway.extensions.automation.decisions import DecisionLog
from dock_gateway.extensions.automation.past import Key
from dock_gateway.extensions.automation.rule import RuleEntry
from dock_gateway.fleet.fleet import Fleet
from dock_gateway.fleet.robot_state import RobotState
from dock_gateway.stop.last_stops import LastStops
from dock_gateway.storage.shared_entries import SharedBook

log = logging.getLogger(__name__)

MAX_RULES = 50


class DockingRules:
    """The rules of all gateways that share the history, and their decisions.

    Args:
        fleet: The state of the robots.
        book: Stores the rules.
        decisions: The decisions.
        last_stops: The robots that were stopped while a rule was on, and wait for a person.

    Attributes:
        waits: Why rules do not dock robots now; `AutomaticDocking` sets it.
    """

    def __init__(
        self, fleet: Fleet, book: SharedBook[RuleEntry], decisions: DecisionLog, last_stops: LastStops
    ) -> None:
        self._fleet = fleet
        self.book = book
        self.decisions = decisions
        self.last_stops = last_stops
        self.waits: dict[Key, WaitReason] = {}

    @property
    def any_on(self) -> bool:
        """Whether a rule is not off."""
        return any(rule.mode is not RuleMode.OFF for rule in self.book.all().values())

    def on_stop(self, robot: str) -> None:
        """Hold a robot that is stopped, if there is a rule that could dock it."""
        if self.any_on:
            self.last_stops.note(robot, utc_now())

    def on_release(self, robot: str) -> None:
        """Hold a robot whose stop is released, as `on_stop`: a release does not make it move."""
        if self.any_on:
            self.last_stops.note_release(robot, utc_now())

    def holds(self, robot: str) -> bool:
        """Return whether no rule docks a robot because it was stopped."""
        return self.last_stops.at(robot) is not None

    async def documents(self, grant: Grant = UNLIMITED) -> list[dict[str, Any]]:
        """Return the rules as `GET /automation/rules` shows them, by name.

        A limited grant gets those that apply to its robots, or name one of them, without the other robots.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        rules = await self.book.read()
        states = self._fleet.states()
        if grant.limited:
            states = [state for state in states if grant.covers_robot(state.name)]
            groups = {group for state in states for group in state.label.groups}
            rules = {key: _narrow(rule, grant, groups) for key, rule in rules.items()}
            rules = {key: rule for key, rule in rules.items() if rule.robots.names or _applies(rule, states)}
        return [
            self._document(rule_id, rule, states)
            for rule_id, rule in sorted(rules.items(), key=lambda item: (item[1].name.casefold(), item[0]))
        ]

    async def document(self, rule_id: str, grant: Grant = UNLIMITED) -> dict[str, Any]:
        """Return a rule as `GET /automation/rules/{rule_id}` shows it.

        Raises:
            NotFound: There is none, or it is not about robots of the grant (`rule_not_found`).
            Unavailable: The history does not answer (`history_unavailable`).
        """
        for rule in await self.documents(grant):
            if rule["id"] == rule_id:
                return rule
        raise self.book.missing(rule_id)

    async def replace(
        self, rule_id: str, rule: RuleEntry, condition: Condition = UNCONDITIONAL
    ) -> tuple[dict[str, Any], bool]:
        """Store a rule, new or changed; return it, and whether it is new. It starts from the beginning with each robot.

        Raises:
            ChangedMeanwhile: It has not the version of the condition.
            Conflict: `limit_reached`.
            Unavailable: The history does not answer (`history_unavailable`); the rule is what it was.
        """
        new = await self.book.replace(rule_id, rule, condition=condition)
        log.info("rule %s (%r) of automatic docking: %s, by %s", rule_id, rule.name, rule.mode.value, rule.changed_by)
        await self._restart(rule_id)
        return self._document(rule_id, rule, self._fleet.states()), new

    async def remove(self, rule_id: str, condition: Condition = UNCONDITIONAL) -> None:
        """Remove a rule.

        Raises:
            ChangedMeanwhile: It has not the version of the condition.
            NotFound: `rule_not_found`.
            Unavailable: The history does not answer (`history_unavailable`); the rule is still there.
        """
        await self.book.remove(rule_id, condition)
        log.info("rule %s of automatic docking removed", rule_id)
        await self._restart(rule_id)

    async def _restart(self, rule_id: str) -> None:
        """Let a rule start from the beginning with each robot: no earlier decision counts."""
        self.waits = {key: wait for key, wait in self.waits.items() if key[0] != rule_id}
        await self.decisions.sync()
        self.decisions.close_rule(rule_id)
        await self.decisions.save()

    def _document(self, rule_id: str, rule: RuleEntry, states: list[RobotState]) -> dict[str, Any]:
        default = WaitReason.OFF if rule.mode is RuleMode.OFF else WaitReason.DECIDING
        return {
            "id": rule_id,
            "etag": self.book.etag(rule),
            **rule.model_dump(),
            "applies_to": [
                {"robot": state.name, "waits_for": self.waits.get((rule_id, state.name), default).value}
                for state in states
                if _applies(rule, [state])
            ],
        }


def _narrow(rule: RuleEntry, grant: Grant, groups: Collection[str]) -> RuleEntry:
    """Return a rule without the robots beyond a grant, and without groups that have none of its robots."""
    chosen = {
        "names": tuple(filter(grant.covers_robot, rule.robots.names)),
        "groups": tuple(group for group in rule.robots.groups if group in groups),
    }
    return rule.model_copy(update={"robots": rule.robots.model_copy(update=chosen)})


def _applies(rule: RuleEntry, states: Iterable[RobotState]) -> bool:
    """Return whether a rule applies to any of these robots."""
    return any(rule.robots.covers(state.name, tuple(state.label.groups)) for state in states)
