"""How things stand: one message for a reader that begins, events for one that resumes."""

from dock_gateway.events import Event, fleet_event, notice, system_event, utc_now
from dock_gateway.gateway import Gateway
from dock_gateway.interest import Interest


async def snapshot(gateway: Gateway, interest: Interest) -> Event:
    """Running and recent goals; the robot's battery, stop and servers; all robots and alerts if asked for."""
    goals = await gateway.recent_goals(interest)
    robot = gateway.robots.get(interest.robot)
    dock, undock = gateway.servers_of(interest.robot)
    fleet = {}
    if "robots" in interest.topics:
        fleet = {"robots": gateway.fleet.documents(), "alerts": gateway.alarm.documents()}
    return notice(
        "snapshot",
        utc_now(),
        ends_goal=interest.goal_id is not None and all(goal.status.terminal for goal in goals),
        goals=[goal.document() for goal in goals],
        battery=robot.battery.document(),
        battery_publisher=robot.publisher.document(),
        stop=gateway.stopper.state(interest.robot),
        action_server=dock,
        undock_server=undock,
        **fleet,
    )


def present(gateway: Gateway, interest: Interest) -> list[Event]:
    """What has no id, and so is not replayed, as it is now: the events that the reader may have missed."""
    name, now = interest.robot, utc_now()
    publisher = gateway.robots.get(name).publisher
    events = [
        system_event("stop", gateway.stopper.state(name), now, robot=name),
        system_event("battery_publisher", publisher.document(), now, robot=name),
    ]
    events += [
        system_event("action_server", state, now, action_name=state.action_name) for state in gateway.servers_of(name)
    ]
    if (simulator := gateway.simulators.document(name)) is not None:
        events.append(system_event("simulator", simulator, now, robot=name))
    wanted = [event for event in events if interest.covers(event)]
    if "robots" in interest.topics:
        wanted.append(fleet_event("robots", now, robots=gateway.fleet.documents(), gone=[]))
        wanted.append(fleet_event("alerts", now, alerts=gateway.alarm.documents()))
    return wanted
