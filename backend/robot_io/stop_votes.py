"""Decides whether a stop holds, by what several publishers say: plain data, without ROS."""

from collections.abc import Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass


@dataclass
class Vote:
    """The last vote of a publisher.

    Attributes:
        latched: Whether it wants the robot to stand still.
        number: Of its message, counted by the publisher.
        said: When, counted over all publishers.
        node: Its node; empty until that is known.
        relays: Whether its node listens to the topic, too, as gateways do.
        gone: When it left, counted in the same way; None while it is there.
    """

    latched: bool
    number: int
    said: int
    node: str = ""
    relays: bool = False
    gone: int | None = None


class StopVotes:
    """The publishers of one stop topic.

    Each publisher has a say of its own: one that wants a stop is not overruled by another. Only gateways, which listen
    to the topic themselves, speak as one, as they agree on what the last of them said. Who leaves while it wants a stop
    is not forgotten: the stop holds until its node is back and says otherwise, or a gateway releases it.
    """

    def __init__(self) -> None:
        self._votes: dict[bytes, Vote] = {}
        self._moment = 0

    def hear(self, publisher: bytes, number: int, *, latched: bool) -> None:
        """Take a message, unless it has come already or is older than another of its publisher.

        Args:
            publisher: The publisher's id.
            number: Of the message, counted by the publisher.
            latched: Whether the publisher wants the robot to stand still.
        """
        before = self._votes.get(publisher)
        if before is not None and number <= before.number:
            return
        self._moment += 1
        node, relays = ("", False) if before is None else (before.node, before.relays)
        self._votes[publisher] = Vote(latched, number, self._moment, node, relays)

    def update_graph(
        self, publishers: Mapping[bytes, str], listeners: set[str], keeping: AbstractSet[bytes] = frozenset()
    ) -> None:
        """Update which publishers and subscribers are on the topic.

        Args:
            publishers: The publishers that are on the topic now, with the names of their nodes.
            listeners: Names of the nodes that subscribe to the topic.
            keeping: The publishers that are taken for gateways while their names are not known: a gateway may release
                a stop and leave before ROS knows its name.
        """
        self._moment += 1
        for publisher, vote in self._votes.items():
            if node := publishers.get(publisher):
                vote.node, vote.relays, vote.gone = node, node in listeners, None
            elif publisher in publishers:
                vote.relays, vote.gone = publisher in keeping, None
            elif vote.gone is None:
                vote.gone = self._moment
        back = {vote.node: vote.said for vote in self._votes.values() if vote.gone is None and vote.node}
        released = max((vote.said for vote in self._gateways if not vote.latched), default=0)
        self._votes = {
            publisher: vote
            for publisher, vote in self._votes.items()
            if vote.gone is None
            or (vote.relays and vote is max(self._gateways, key=lambda gateway: gateway.said))
            or (not vote.relays and vote.latched and released < vote.gone and back.get(vote.node, 0) < vote.said)
        }

    @property
    def _gateways(self) -> list[Vote]:
        return [vote for vote in self._votes.values() if vote.relays]

    @property
    def unknown(self) -> bool:
        """Whether someone has spoken whose node is not known yet."""
        return any(not vote.node for vote in self._votes.values())

    @property
    def held(self) -> bool:
        """Whether a stop holds."""
        last = max(self._gateways, key=lambda vote: vote.said, default=None)
        others = any(vote.latched for vote in self._votes.values() if not vote.relays)
        return others or (last is not None and last.latched)
