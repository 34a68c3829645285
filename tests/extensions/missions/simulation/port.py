"""An action as one gateway reaches it, in place of `dock_gateway.ros.action_port`."""

import asyncio
import json
from collections.abc import Callable
from contextvars import Context
from typing import TYPE_CHECKING, Any

from dock_gateway.ros.action_link import ServerPresence
from dock_gateway.ros.action_port import CancelAnswer
from dock_gateway.ros.status import StatusReport
from tests.dock_gateway.simulation.chance import TICK
from tests.extensions.missions.simulation.server import Call

if TYPE_CHECKING:
    from tests.extensions.missions.simulation.gateway import Gateway


class Codec:
    """Messages that are JSON, with any fields."""

    async def read(self, request: Any, _: str = "") -> Any:
        return request

    def parse(self, request: Any, _: str = "", __: Any = ()) -> Any:
        return request


class Port:
    """An action as one gateway reaches it."""

    goal_codec = Codec()
    listener = None
    unanswered_since = None
    answered = True
    away = False

    def __init__(self, bridge: "Bridge", action_name: str, kind: Any) -> None:
        self.action_name = action_name
        self.action_type = kind.name
        self.gateway = bridge.gateway
        self._server = bridge.gateway.servers[action_name]
        self._busy_until = 0.0
        self._on_status: Callable[..., object] = lambda *_: None

    def listen(self, on_status: Callable[..., object], *_: Any) -> None:
        self._on_status = on_status
        self._server.readers.append(self)
        self._server.tell_to(self)

    def close(self) -> None:
        if self in self._server.readers:
            self._server.readers.remove(self)

    def on_status(self, reports: list[StatusReport], stamp_ns: int) -> None:
        self._on_status(reports, stamp_ns)

    def carry(self, message: Callable[[], object]) -> None:
        """Bring a message to the gateway; messages arrive in their order."""
        loop = self.gateway.chance.loop
        at = max(loop.time() + self.gateway.chance.latency(), self._busy_until + TICK)
        self._busy_until = at

        def arrive() -> None:
            if not self.gateway.dead and self._server.robot.in_reach:
                with self.gateway.running():
                    message()

        loop.call_at(at, arrive, context=Context())

    def encode_goal(self, goal: Any) -> bytes:
        return json.dumps(goal, sort_keys=True).encode()

    def send(self, goal_id: str, message: Any) -> Call:
        gateway, encoded, call = self.gateway, self.encode_goal(message), Call()
        if gateway.dead:
            raise OSError("killed")
        gateway.world.on_send(gateway, self._server, goal_id, message)
        self._server.request(self, call, lambda: self._server.take(goal_id, encoded))
        gateway.may_be_killed()
        return call

    def request_result(self, goal_id: str) -> Call:
        call = Call()

        def handle() -> None:
            self._server.await_result(goal_id, lambda answer: self.carry(lambda: call.answer(answer)))

        self._server.request(self, call, handle)
        return call

    async def cancel(self, goal_id: str | None, timeout: float) -> CancelAnswer:
        if self.gateway.dead:
            raise OSError("killed")
        call = Call()
        self._server.request(self, call, lambda: self._server.cancel(goal_id))
        async with asyncio.timeout(timeout):
            answer: CancelAnswer = await call.response
        return answer

    async def presence(self) -> ServerPresence:
        return ServerPresence(available=self._server.there)

    async def ping(self, timeout: float) -> bool:
        call = Call()
        self._server.request(self, call, lambda: True)
        try:
            async with asyncio.timeout(timeout):
                return bool(await call.response)
        except TimeoutError:
            return False


class Bridge:
    """Calls what would run on the ROS thread at once."""

    def __init__(self, gateway: "Gateway") -> None:
        self.gateway = gateway

    async def call(self, work: Callable[[], Any], undo: Any = None) -> Any:
        return work()

    def to_ros(self, work: Callable[[], Any]) -> None:
        work()
