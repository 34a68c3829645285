"""Detects two action servers with one name. Each executes every goal, so both move the robot."""

from dock_gateway.ros.action_link import ServerPresence

# Seconds after which a server on the graph counts as alive: a killed server stays there for up to 20 s.
SETTLED = 25.0


class Duplicates:
    """Detects whether one action has more than one live server.

    Two answers to one request are proof. Servers that block their only thread do not answer; for those, the proof is
    that two stay on the graph for longer than a dead one could.
    """

    def __init__(self) -> None:
        self._since: dict[str, float] = {}  # by server

    def found(self, presence: ServerPresence, now: float) -> bool:
        """Return whether there is more than one live server.

        Args:
            presence: The servers on the graph.
            now: Seconds on the monotonic clock.
        """
        self._since = {server: self._since.get(server, now) for server in presence.servers}
        settled = sum(now - since > SETTLED for since in self._since.values())
        return len(presence.servers) > 1 and (settled > 1 or now - presence.answered_twice_at < SETTLED)
