"""Collects the messages of one robot for its ring buffer."""

import logging
import time
from typing import Any

from dock_gateway.core.errors import GatewayError
from dock_gateway.core.goal import encode
from dock_gateway.extensions.recordings.offered_qos import offered_qos
from dock_gateway.extensions.recordings.ring import Ring
from dock_gateway.extensions.recordings.topics import CAMERA, RecordedTopic
from dock_gateway.graph.received import Received
from dock_gateway.graph.relays import Relays
from dock_gateway.graph.subscription import MOST_KEPT
from robot_io.recording import Sample, event_sample

log = logging.getLogger(__name__)

# Nanoseconds between two pictures of a camera.
PICTURE_NS = 950_000_000


class RobotCollector:
    """Collects the messages of one robot for its ring buffer: an `Outlet` of all its topics."""

    patient = True

    def __init__(self, ring: Ring) -> None:
        self.ring = ring
        self.topics: dict[str, RecordedTopic] = {}
        self._refused: dict[str, RecordedTopic] = {}
        self._pictures: dict[str, int] = {}

    async def listen(self, relays: Relays, wanted: dict[str, RecordedTopic]) -> None:
        """Listen to these topics, and to no others any longer. What is refused is not asked for again."""
        for topic in [topic for topic, kind in self.topics.items() if wanted.get(topic) != kind]:
            del self.topics[topic]
            await relays.leave(topic, self)
        self._refused = {topic: kind for topic, kind in self._refused.items() if wanted.get(topic) == kind}
        for topic, kind in wanted.items():
            if topic in self.topics or topic in self._refused:
                continue
            self.topics[topic] = kind
            try:
                await relays.join(topic, kind.kind or None, self)
            except GatewayError as error:
                del self.topics[topic]
                self._refused[topic] = kind
                log.info("%s is not recorded: %s", topic, error.detail)
            except BaseException:
                del self.topics[topic]
                raise

    async def offer(self, message: Received) -> None:
        """Keep a message; of a camera one in a second."""
        kind = message.kind.name
        if kind == CAMERA:
            if 0 <= message.received_ns - self._pictures.get(message.topic, 0) < PICTURE_NS:
                return
            self._pictures[message.topic] = message.received_ns
        wanted = self.topics.get(message.topic)
        kept = MOST_KEPT if wanted is not None and wanted.lasting else message.kept
        qos = offered_qos(reliable=message.reliable, kept=kept)
        self.ring.put(Sample(message.topic, kind, message.data, message.source_ns, message.received_ns, qos), kept=kept)

    def note(self, document: dict[str, Any]) -> None:
        """Keep an event of the gateway."""
        self.ring.put(event_sample(encode(document), time.time_ns()))
