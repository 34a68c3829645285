"""The gateway put together: every part of it, made in the right order and closed in the reverse."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass

from dock_gateway.battery import Battery, BatteryPublisher
from dock_gateway.events import message_event, system_event, utc_now
from dock_gateway.goals import Goal
from dock_gateway.history import MemoryHistory
from dock_gateway.hub import Hub
from dock_gateway.liveness import ServerWatch
from dock_gateway.ros.actions import ActionPort
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.topics import BatteryPort, DiagnosticsPort, VelocityPort
from dock_gateway.service import GoalService
from dock_gateway.settings import Settings
from dock_gateway.tracker import GoalTracker


@dataclass(frozen=True)
class Gateway:
    """What the API calls."""

    settings: Settings
    bridge: Bridge
    hub: Hub
    goals: GoalService
    tracker: GoalTracker
    watch: ServerWatch
    battery: Battery
    publisher: BatteryPublisher
    dock: ActionPort

    def say_goodbye(self) -> None:
        """The gateway is about to close: end every stream and every wait."""
        self.hub.close()
        self.tracker.release_all()


@asynccontextmanager
async def open_gateway(settings: Settings) -> AsyncIterator[Gateway]:
    """Join the ROS graph and run the gateway until the block ends."""
    hub = Hub(queue_limit=settings.subscriber_queue, max_subscribers=settings.max_subscribers)
    history = MemoryHistory(settings.max_goals)

    def on_return(goal: Goal) -> None:
        goals.on_return(goal)

    tracker = GoalTracker(hub, history, on_return=on_return)
    battery = Battery(hub, settings.battery_stale_after)
    bridge = Bridge(settings.node_name, settings.namespace)
    try:
        dock = ActionPort(
            bridge,
            settings.resolve(settings.dock_action),
            settings.dock_action_type,
            on_status=tracker.on_status,
            on_feedback=tracker.on_feedback,
        )
        tracker.attach(dock)
        battery_port = BatteryPort(bridge, settings.battery_topic, battery.on_battery)
        velocity = VelocityPort(
            bridge,
            settings.cmd_vel_topic,
            lambda message, stamp_ns: hub.publish(message_event("cmd_vel", message, stamp_ns)),
        )
        DiagnosticsPort(bridge, settings.diagnostics_topic, tracker.on_reason)
        watch = ServerWatch(
            tracker, settings, lambda state: hub.publish(system_event("action_server", state, utc_now()))
        )
        goals = GoalService(settings, history, tracker, watch, velocity)
        publisher = BatteryPublisher(battery_port, hub)
        bridge.start()
        watching = asyncio.create_task(watch.run())
        try:
            yield Gateway(settings, bridge, hub, goals, tracker, watch, battery, publisher, dock)
        finally:
            hub.close()
            watching.cancel()
            with suppress(asyncio.CancelledError):
                await watching
            await publisher.stop()
            await tracker.close()
    finally:
        await asyncio.to_thread(bridge.close)
