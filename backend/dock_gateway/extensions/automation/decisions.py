"""The decisions of all gateways that share the history: claimed before they are carried out, and published."""

import logging
from collections.abc import Mapping
from datetime import datetime
from typing import Any

from dock_gateway.core.cursor import Cursor, newest
from dock_gateway.core.event import fleet_event, utc_now
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.grant import UNLIMITED, Grant
from dock_gateway.extensions.automation.decision import DecisionEntry, DecisionOutcome
from dock_gateway.extensions.automation.past import require_free
from dock_gateway.storage import Entries
from dock_gateway.storage.shared_entries import SharedEntries

log = logging.getLogger(__name__)


class DecisionLog(SharedEntries[DecisionEntry]):
    """The stored decisions. It publishes each once it is final, whichever gateway made it.

    Args:
        fanout: Receives events.
        store: Stores them.
        most: Maximum number of decisions that are kept, besides those that still count; the oldest are deleted.
    """

    def __init__(self, fanout: Fanout, store: Entries[DecisionEntry], most: int = 1000) -> None:
        super().__init__(store)
        self._fanout = fanout
        self._most = most
        self._published: set[str] | None = None  # None until they have been read once

    async def read(self) -> Mapping[str, DecisionEntry]:
        """Store pending changes, read other gateways' decisions, publish the new ones, and return all by their ids.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        decisions = await super().read()
        final = {
            identity for identity, decision in decisions.items() if decision.outcome is not DecisionOutcome.SENDING
        }
        if self._published is not None:
            for identity in final - self._published:
                self._publish(identity)
        self._published = final
        return decisions

    async def claim(self, identity: str, decision: DecisionEntry) -> None:
        """Store a decision before it is carried out.

        Raises:
            Conflict: Another gateway was first.
            Unavailable: The history does not answer (`history_unavailable`); nothing is to be done.
        """
        await self.store(identity, decision, lambda stored: require_free(decision, stored))

    def finish(self, identity: str, decision: DecisionEntry) -> None:
        """Record what came of a claimed decision. `sync` stores it if the history does not answer now."""
        if self.all().get(identity) != decision:
            self.put(identity, decision)
        if self._published is not None:
            self._published.add(identity)
        _log(decision)
        self._publish(identity)
        ended = sorted((each.decided_at, key) for key, each in self.all().items() if not each.open)
        for _, oldest in ended[: -self._most]:
            self.put(oldest, None)

    def close_series(self, identities: list[str]) -> None:
        """Let open decisions no longer count for later ones."""
        for identity in identities:
            self.put(identity, self.all()[identity].model_copy(update={"open": False}))

    def close_rule(self, rule_id: str) -> None:
        """Let the open decisions of a rule no longer count for later ones."""
        self.close_series(
            [
                identity
                for identity, decision in self.all().items()
                if decision.open and decision.rule_id == rule_id and decision.outcome is not DecisionOutcome.SENDING
            ]
        )

    def given_up(self) -> dict[str, DecisionEntry]:
        """Return, by robot, the decisions to give up that still count."""
        return {
            decision.robot: decision
            for decision in self.all().values()
            if decision.open and decision.outcome is DecisionOutcome.GAVE_UP
        }

    def interrupted(self, before: datetime) -> dict[str, DecisionEntry]:
        """Return the decisions older than this that no gateway has finished."""
        return {
            identity: decision
            for identity, decision in self.all().items()
            if decision.outcome is DecisionOutcome.SENDING and decision.decided_at < before
        }

    async def has(self, robot: str) -> bool:
        """Return whether there is a decision about a robot.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        return any(decision.robot == robot for decision in (await self.read()).values())

    async def page(
        self,
        *,
        robot: str | None = None,
        rule_id: str | None = None,
        goal_id: str | None = None,
        limit: int,
        end: Cursor | None = None,
        grant: Grant = UNLIMITED,
    ) -> tuple[list[dict[str, Any]], Cursor | None]:
        """Return the decisions of a grant as `GET /automation/decisions` shows them, newest first.

        Args:
            robot: Only about this robot.
            rule_id: Only of this rule.
            goal_id: Only the one that sent this goal.
            limit: The length of a page.
            end: Where the page before ended; None for the first one.
            grant: The grant of who asks.

        Returns:
            The page, and where it ends; None if it is the last one.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        decisions = await self.read()
        found = [
            Cursor(decision.decided_at, identity)
            for identity, decision in decisions.items()
            if robot in (None, decision.robot)
            and rule_id in (None, decision.rule_id)
            and goal_id in (None, decision.goal_id)
            and grant.covers_robot(decision.robot)
        ]
        places, end = newest(found, limit, end)
        return [_document(each.id, decisions[each.id]) for each in places], end

    def _publish(self, identity: str) -> None:
        decision = _document(identity, self.all()[identity])
        self._fanout.publish(fleet_event("automation", utc_now(), narrow_decision, automation=decision))


def narrow_decision(document: dict[str, Any], grant: Grant) -> dict[str, Any] | None:
    """Return a decision about a robot that a grant covers."""
    return document if grant.covers_robot(document["automation"]["robot"]) else None


def _document(identity: str, decision: DecisionEntry) -> dict[str, Any]:
    return {"id": identity, **decision.model_dump(exclude={"open"})}


def _log(decision: DecisionEntry) -> None:
    """Write the one log line of a decision."""
    battery = "unknown" if decision.battery is None else f"{decision.battery:.0%}"
    condition = (
        f"idle since {decision.idle_since_at:%H:%M:%S} UTC"
        if decision.scheduled_at is None and decision.idle_since_at is not None
        else f"due at {decision.scheduled_at:%H:%M} UTC"
        if decision.scheduled_at is not None
        else "idle"
    )
    reason = ", ".join(filter(None, (decision.goal_id and f"goal {decision.goal_id}", decision.code, decision.detail)))
    log.log(
        logging.WARNING if decision.outcome in (DecisionOutcome.GAVE_UP, DecisionOutcome.REFUSED) else logging.INFO,
        "automatic docking of %s by the rule %r: %s (battery %s, %s)%s",
        decision.robot,
        decision.rule_name,
        decision.outcome.value,
        battery,
        condition,
        f": {reason}" if reason else "",
    )
