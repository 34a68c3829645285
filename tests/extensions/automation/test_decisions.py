"""A reader sees the decisions about the robots that their grant covers."""

from dock_gateway.core.event import fleet_event, utc_now
from dock_gateway.core.grant import Grant, Role
from dock_gateway.core.narrowing import narrow
from dock_gateway.extensions.automation.decisions import narrow_decision


def test_a_decision_about_another_robot_is_left_out() -> None:
    grant, now = Grant(Role.OPERATOR, robots=("/robot1",)), utc_now()
    other, own = (
        fleet_event("automation", now, narrow_decision, automation={"robot": robot}) for robot in ("/robot2", "/robot1")
    )
    assert narrow(other, grant) is None
    shown = narrow(own, grant)
    assert shown is not None
    assert shown.data == own.data
