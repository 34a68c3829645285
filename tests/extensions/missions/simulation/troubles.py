"""What a run of the simulation is: how long, with how many robots, and what goes wrong in it."""

from dataclasses import dataclass

from tests.dock_gateway.simulation.chance import Faults

HOUR = 3600.0


@dataclass(frozen=True)
class Troubles(Faults):
    """A run. Times are in seconds; what happens by itself happens once in so many seconds, on average.

    Attributes:
        robots, docks, schedules: How many there are.
        waiting_places: Share of the docks that have places where robots wait for them.
        rules: How many of the robots a rule docks when their battery is low.
        holds_every: Somebody lets the rule go on with a robot that was stopped.
        navigating: Share of the robots that have nav2, which drives them there.
        battery_speed: How many times faster than in a real robot batteries are charged and discharged.
        lasts: How long the troubles last. After that, everything works and people continue what is held.
        schedule_minutes: A schedule queues a mission every one to four times so many minutes.
        missions_every: Of each robot, another mission.
        groups_every: Another mission for whichever robot of a group is free.
        people_every: Of all robots, somebody pauses, continues, skips or cancels a mission, or cancels a goal.
        stops_every: Somebody stops a robot, or all of them.
        goals_every: Somebody sends a goal past the missions.
        kills_every: A gateway is killed.
        kills_at_writes: How likely it is that one is killed right before or after something is stored.
        kills_at_sends: The same for a goal that is sent.
        servers_every: An action server ends, freezes, or a robot is switched off or out of reach.
        docks_every: A dock is blocked.
        repairs_every: Somebody says that all docks are in order again.
        batteries_every: Somebody looks for robots with an empty battery, and changes it.
        answers_lost: Share of the answers of servers that are lost.
        scan_every: A gateway reads the ROS graph.
        look_every: A gateway looks at missions, if nothing else wakes it.
    """

    gateways: int = 1
    robots: int = 3
    docks: int = 2
    waiting_places: float = 0.6
    navigating: float = 0.85
    rules: int = 2
    holds_every: float = 150.0
    schedules: int = 1
    battery_speed: float = 15.0
    lasts: float = HOUR / 2
    schedule_minutes: int = 1
    missions_every: float = 200.0
    groups_every: float = 200.0
    people_every: float = 30.0
    stops_every: float = 300.0
    goals_every: float = 300.0
    kills_every: float = 300.0
    kills_at_writes: float = 0.002
    kills_at_sends: float = 0.02
    servers_every: float = 120.0
    docks_every: float = 400.0
    repairs_every: float = 300.0
    batteries_every: float = 200.0
    answers_lost: float = 0.02
    scan_every: float = 5.0
    look_every: float = 5.0


WEEK = Troubles(
    gateways=1,
    robots=10,
    docks=4,
    schedules=2,
    lasts=7 * 24 * HOUR,
    battery_speed=1.0,
    schedule_minutes=60,
    missions_every=2 * HOUR,
    groups_every=HOUR / 2,
    people_every=900.0,
    stops_every=4 * HOUR,
    goals_every=2 * HOUR,
    kills_every=4 * HOUR,
    servers_every=HOUR,
    docks_every=2 * HOUR,
    repairs_every=HOUR,
    batteries_every=HOUR / 2,
    scan_every=60.0,
    look_every=30.0,
)
