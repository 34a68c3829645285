"""The rules of automatic docking, shared by the gateways that share a history."""

import logging
from collections.abc import Mapping

from dock_gateway.core.automation import Rule
from dock_gateway.core.errors import Conflict, NotFound
from dock_gateway.fleet.shared_entries import SharedEntries
from dock_gateway.history import Entries

log = logging.getLogger(__name__)

MAX_RULES = 50


class RuleBook:
    """Holds the rules, by id.

    Args:
        store: Stores them.
    """

    def __init__(self, store: Entries[Rule]) -> None:
        self._entries = SharedEntries(store)

    def all(self) -> Mapping[str, Rule]:
        """Return the rules by their ids, as they were read last."""
        return self._entries.all()

    async def sync(self) -> bool:
        """Read other gateways' changes; return False if the history is unavailable."""
        return await self._entries.sync()

    async def read(self) -> Mapping[str, Rule]:
        """Return the rules as they are stored now.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        return await self._entries.read()

    async def replace(self, rule_id: str, rule: Rule) -> None:
        """Store a rule, new or changed.

        Raises:
            Conflict: `too_many_rules`.
            Unavailable: The history does not answer (`history_unavailable`); the rule is what it was.
        """

        def check(rules: Mapping[str, Rule]) -> None:
            if rule_id not in rules and len(rules) >= MAX_RULES:
                raise Conflict(f"there are {MAX_RULES} rules; remove one first", code="too_many_rules")

        await self._entries.store(rule_id, rule, check)
        log.info("rule %s (%r) of automatic docking: %s, by %s", rule_id, rule.name, rule.mode.value, rule.changed_by)

    async def remove(self, rule_id: str) -> None:
        """Remove a rule.

        Raises:
            NotFound: `rule_not_found`.
            Unavailable: The history does not answer (`history_unavailable`); the rule is still there.
        """

        def check(rules: Mapping[str, Rule]) -> None:
            if rule_id not in rules:
                raise NotFound(f"there is no rule {rule_id}", code="rule_not_found")

        await self._entries.store(rule_id, None, check)
        log.info("rule %s of automatic docking removed", rule_id)
