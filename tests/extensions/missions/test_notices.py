"""What missions tell people, as alerts: how long, and one after the other."""

from datetime import datetime, timedelta

from dock_gateway.extensions.missions.mission import MissionEntry, MissionStatus, Notice
from dock_gateway.extensions.missions.notices import Notices
from tests.extensions.missions.examples import DOCK, NOON, after, begun


class Clock:
    """A clock that stands until it is moved."""

    now = NOON

    def __call__(self) -> datetime:
        return self.now


def telling(text: str, at: datetime = NOON, **fields: object) -> MissionEntry:
    """A mission of the robot `/` that has told people something."""
    return begun(DOCK).but(notice=Notice(text=text, critical=False, told_at=at), **fields)


def test_a_notice_is_an_alert_of_its_robot() -> None:
    notices = Notices(Clock())
    notices.add("a", telling("Load me", name="Night"))
    (alert,) = notices.alerts(["/robot1", "/"])
    assert (alert.kind.value, alert.robot, alert.started_at) == ("mission_notice", "/", NOON)
    assert (alert.title, alert.detail, alert.critical) == ("Mission Night", "Load me", False)
    critical = Notice(text="Help", critical=True, told_at=after(1))
    notices.add("a", telling("").but(notice=critical))
    assert [*notices.alerts(["/"])] == []  # so that the new one is told as one, too
    (alert,) = notices.alerts(["/"])
    assert (alert.title, alert.detail, alert.critical) == ("Mission", "Help", True)


def test_a_notice_stands_while_its_mission_says_so_and_a_minute_at_least() -> None:
    clock = Clock()
    notices = Notices(clock)
    mission = telling("Load me")
    notices.update({"a": mission})
    clock.now += timedelta(hours=1)
    assert len([*notices.alerts(["/"])]) == 1
    notices.update({})  # it has ended elsewhere
    assert [*notices.alerts(["/"])] == []
    clock.now = NOON
    notices.add("a", mission.but(status=MissionStatus.SUCCEEDED))
    for seconds, count in ((59, 1), (60, 0), (0, 0)):
        clock.now = after(seconds)
        assert len([*notices.alerts(["/"])]) == count


def test_an_earlier_notice_does_not_replace_a_later_one() -> None:
    notices = Notices(Clock())
    notices.add("b", telling("Later", after(5)))
    notices.add("a", telling("Earlier"))
    notices.add("c", begun(DOCK))
    assert [alert.detail for alert in notices.alerts(["/"])] == ["Later"]
