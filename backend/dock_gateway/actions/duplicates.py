"""Two action servers with one name: each of them carries out every goal, so that both move the robot."""

from dock_gateway.ros.action_port import Presence

# A server that was killed stays on the graph for up to 20 s. For longer than this (seconds) only a living one does.
SETTLED = 25.0


class Duplicates:
    """Tells whether one action has more than one living server.

    Two answers to one request are proof. Servers that work inside their only thread answer nothing meanwhile; of those,
    two that stay on the graph for longer than a dead one could.
    """

    def __init__(self) -> None:
        self._since: dict[str, float] = {}  # by server

    def found(self, presence: Presence, now: float) -> bool:
        """Whether there is more than one.

        Args:
            presence: Who is on the graph.
            now: Seconds on the monotonic clock.
        """
        self._since = {server: self._since.get(server, now) for server in presence.servers}
        settled = sum(now - since > SETTLED for since in self._since.values())
        return len(presence.servers) > 1 and (settled > 1 or now - presence.answered_twice_at < SETTLED)
