"""Who sends the goal of a step, where several gateways follow its mission: one of them, as the stored mission says.

The one that stores the beginning of a try sends its goal. Until it has stored the goal, or its time is over, no other
gateway takes the mission further: the goal may be on its way. Rules over plain data.
"""

from datetime import datetime, timedelta

from dock_gateway.extensions.missions.mission import MissionEntry
from dock_gateway.extensions.missions.moves import Change, Facts, Wait, WaitsFor
from dock_gateway.extensions.missions.step_entry import StepEntry

# How long a gateway may send after it has stored that it does; longer than a submission takes, with all its waits.
SENDS_FOR = timedelta(seconds=60)


def taken_on(facts: Facts, now: datetime) -> dict[str, object]:
    """Return the fields of a step whose goal this gateway sends from now on."""
    alone = facts.gateway is None
    return {"sender": facts.gateway, "sends_until": None if alone else now + SENDS_FOR}


def wait_for_sender(step: StepEntry, facts: Facts, now: datetime) -> Wait | None:
    """Return the wait for another gateway that may be sending the goal of a step; None: no other does."""
    being_sent = step.has_goal and step.goal_id is None
    if facts.gateway is None or not being_sent or step.sends_until is None or step.sender == facts.gateway:
        return None
    return Wait(WaitsFor.GOAL, step.sends_until) if now < step.sends_until else None


def before_send(mission: MissionEntry, facts: Facts, now: datetime) -> Change | None:
    """Return what is stored before this gateway sends the goal of the present step; None: nothing.

    It takes over from one that has not sent it in time, and extends its own time, as while it waits for a server.
    """
    step = mission.current
    if facts.gateway is None:
        return None
    in_time = step.sends_until is not None and now < step.sends_until - SENDS_FOR / 2
    return None if step.sender == facts.gateway and in_time else Change(mission.with_step(**taken_on(facts, now)))
