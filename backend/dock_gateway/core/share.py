"""A gateway's share of the robots of its ROS domain, and the claims of all gateways on one database. Plain data."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from functools import cached_property, lru_cache
from types import MappingProxyType
from typing import Any

from dock_gateway.core.errors import ServedElsewhere
from dock_gateway.core.grant import Grant
from dock_gateway.core.patterns import match_namespaces, overlap

# Grants that are remembered with a share in them.
MAX_GRANTS = 512


@dataclass(frozen=True)
class Claim:
    """A gateway that runs, as it is stored in the database.

    Attributes:
        host: Name of its machine.
        boot: Id of the machine since it was started.
        address: Where it listens; empty if that is not known yet.
        robots: Patterns of the namespaces that it serves; empty: all.
        serves: Namespaces of the robots that it has found.
        version: Its version.
        started_at: When it started.
        seen_at: When it last stored this, by its own clock.
        beat: Counts how often it has.
        claimed: Whether the robots are its own. Not so if another gateway had them first.
    """

    host: str
    boot: str
    address: str
    robots: tuple[str, ...]
    serves: tuple[str, ...]
    version: str
    started_at: datetime
    seen_at: datetime
    beat: int
    claimed: bool = True

    @property
    def where(self) -> str:
        """The gateway in a sentence."""
        return f"the gateway at {self.address} on {self.host}" if self.address else f"a gateway on {self.host}"

    @property
    def what(self) -> str:
        """The robots in a sentence."""
        return ", ".join(self.robots) or "every robot"

    def replaces(self, other: "Claim") -> bool:
        """Return whether the other gateway must have ended: this one has the same port of the same machine."""
        places = ((claim.host, claim.boot, claim.address) for claim in (self, other))
        return bool(self.address) and len({*places}) == 1

    def covers(self, name: str) -> bool:
        """Return whether it serves what has a name on the ROS graph."""
        return match_namespaces(self.robots).fullmatch(name) is not None

    def document(self) -> dict[str, Any]:
        """Return how to find it, ready for `orjson`."""
        return {"host": self.host, "address": self.address or None, "robots": self.robots}


def compete(some: Iterable[str], others: Iterable[str]) -> bool:
    """Return whether two gateways with these patterns serve the same robots, and must not.

    Gateways that serve every robot are replicas of each other.
    """
    first, second = tuple(some), tuple(others)
    if not first or not second:
        return first != second
    return any(overlap(one, other) for one in first for other in second)


class Share:
    """The robots that this gateway serves.

    Args:
        robots: Patterns of their namespaces; empty: all. A namespace includes those below it, but `/` is only the robot
            without a namespace.
        homes: The robots of actions that are not in the namespace of their robot.

    Attributes:
        patterns: The patterns, with a slash at the beginning and none at the end.
        others: Returns the claims of the other gateways on the same database.
    """

    def __init__(self, robots: Iterable[str] = (), homes: Mapping[str, str] = MappingProxyType({})) -> None:
        self.patterns = tuple(f"/{each.strip('/')}" for each in robots)
        self.others: Callable[[], Iterable[Claim]] = tuple
        self._homes = homes
        self._expression = match_namespaces(self.patterns)
        self.narrow = lru_cache(MAX_GRANTS)(self._narrow)

    @property
    def limited(self) -> bool:
        """Whether there may be robots that this gateway does not serve."""
        return bool(self.patterns)

    def covers(self, name: str) -> bool:
        """Return whether an action, or what else has a name on the ROS graph, belongs to one of the robots."""
        home = self._homes.get(name)
        return self._expression.fullmatch(name) is not None if home is None else self.covers_robot(home)

    def covers_robot(self, namespace: str) -> bool:
        """Return whether a robot is one of them."""
        return self._expression.fullmatch(_name_in(namespace)) is not None

    def _narrow(self, grant: Grant) -> Grant:
        return replace(grant, share=self) if self.limited else grant

    def require(self, name: str, about: str) -> None:
        """Refuse what does not belong to one of the robots.

        Args:
            name: Its name on the ROS graph.
            about: What it is, in a sentence.

        Raises:
            ServedElsewhere: It does not; the sentence says which gateway serves it, if that is known.
        """
        if not self.covers(name):
            raise self._elsewhere(self._homes.get(name, name), about)

    def require_robot(self, namespace: str) -> None:
        """Refuse a robot that is not one of them.

        Raises:
            ServedElsewhere: It is not.
        """
        if not self.covers_robot(namespace):
            hint = "; name one of its own with `robot`" if namespace == "/" else ""
            raise self._elsewhere(_name_in(namespace), f"the robot {namespace[:100]}", hint)

    def _elsewhere(self, name: str, about: str, hint: str = "") -> ServedElsewhere:
        other = next((claim for claim in self.others() if claim.claimed and claim.covers(name)), None)
        does = "no other gateway is known that does" if other is None else f"{other.where} does"
        detail = f"this gateway serves {self.what}, not {about}: {does}{hint}"
        return ServedElsewhere(detail, gateway=None if other is None else other.document())

    @cached_property
    def what(self) -> str:
        """The robots in a sentence."""
        return ", ".join(self.patterns) or "every robot"


def _name_in(namespace: str) -> str:
    return f"{namespace.rstrip('/')}/_"


EVERYTHING = Share()
