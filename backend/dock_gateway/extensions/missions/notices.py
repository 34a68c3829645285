"""What missions have told people, and what they need people for, as alerts."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from datetime import datetime
from typing import NamedTuple

from dock_gateway.core.event import utc_now
from dock_gateway.extensions.missions.mission import HoldReason, MissionEntry, Notice, Recharge, RechargeStage
from dock_gateway.fleet.alert import Alert
from dock_gateway.fleet.alert_kinds import AlertKind

NOTICE = AlertKind("mission_notice", critical=False)
RETURN_FAILED = AlertKind("mission_return_failed")
UNAPPROVED = AlertKind("mission_unapproved", critical=False)


def alerts_of_holds(missions: Iterable[MissionEntry]) -> Iterator[Alert]:
    """Return an alert for each robot that could not be charged or leave its dock, and for what agents ask for."""
    asked: dict[str | None, MissionEntry] = {}  # the oldest of each robot
    for mission in missions:
        if mission.held_for is HoldReason.RECHARGE and mission.recharge is not None:
            yield _failed_return(mission.robot or "", mission.recharge)
        first = asked.get(mission.robot, mission)
        if mission.held_for is HoldReason.APPROVAL and mission.created_at <= first.created_at:
            asked[mission.robot] = mission
    for robot, mission in asked.items():
        detail = (
            f"{mission.created_by or 'An agent'} asks for it. See its steps under Missions, then continue or cancel it."
        )
        yield Alert(UNAPPROVED, robot, mission.created_at, "A mission needs your approval", detail)


def _failed_return(robot: str, recharge: Recharge) -> Alert:
    leaving = recharge.stage is RechargeStage.UNDOCKING
    title = f"{robot} did not leave its dock" if leaving else f"{robot} could not be charged"
    why = "" if recharge.step.error is None else f" The last try: {recharge.step.error.detail.rstrip('.')}."
    detail = f"Its mission is held after {recharge.step.tried} tries.{why} Check the robot and its dock, then continue."
    return Alert(RETURN_FAILED, robot, recharge.step.finished_at or recharge.started_at, title, detail)


class _Told(NamedTuple):
    """A notice, and the mission that it is of."""

    notice: Notice
    mission_id: str
    name: str | None

    def over(self) -> "_Told":
        """Return it without its mission's being on its way."""
        return self._replace(notice=self.notice.model_copy(update={"standing": False}))


class Notices:
    """The last notice of each robot's missions. It is an alert until the step after it has ended, a minute at least.

    Args:
        clock: Returns the time.
    """

    def __init__(self, clock: Callable[[], datetime] = utc_now) -> None:
        self._clock = clock
        self._told: dict[str, _Told] = {}  # by robot
        self._shown: dict[str, datetime] = {}  # when that was told which is an alert, by robot

    def add(self, mission_id: str, mission: MissionEntry) -> None:
        """Take the notice of a mission into account, if it has one."""
        if mission.notice is None:
            return
        robot, new = mission.its_robot, _Told(mission.notice, mission_id, mission.name)
        known = self._told.get(robot)
        if known is None or known.notice.told_at <= new.notice.told_at:
            self._told[robot] = new.over() if mission.status.ended else new

    def update(self, missions: Mapping[str, MissionEntry]) -> None:
        """Take the notices of the missions that have not ended into account; a mission that is missing has ended."""
        for robot, told in self._told.items():
            if told.mission_id not in missions:
                self._told[robot] = told.over()
        for mission_id, mission in missions.items():
            self.add(mission_id, mission)

    def alerts(self, robots: Iterable[str]) -> Iterator[Alert]:
        """Return the alerts of some robots. A notice that replaces another one is an alert a moment later."""
        now = self._clock()
        for robot in robots:
            told, shown = self._told.get(robot), self._shown.pop(robot, None)
            if told is None or not told.notice.is_active(now):
                self._told.pop(robot, None)
            elif shown in (None, told.notice.told_at):
                self._shown[robot] = told.notice.told_at
                title = f"Mission {told.name}" if told.name else "Mission"
                yield Alert(NOTICE, robot, told.notice.told_at, title, told.notice.text, urgent=told.notice.critical)
