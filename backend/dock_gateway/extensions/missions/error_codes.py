"""The error codes of this extension."""

from dock_gateway.core.error_codes import ErrorCode

CODES = (
    ErrorCode("mission_not_found", 404, "There is no mission with this id."),
    ErrorCode("mission_ended", 409, "The mission has ended, so that it cannot be changed."),
    ErrorCode("mission_begun", 409, "The mission has begun: only one that has not is edited, or moved in the queue."),
    ErrorCode("other_queue", 409, "The mission to move another one next to is in the queue of other robots."),
    ErrorCode("mission_not_held", 409, "Only a mission that is held can be continued, or go on without its step."),
    ErrorCode("place_not_found", 404, "There is no place with this id; of a step: not any more."),
    ErrorCode("template_not_found", 404, "There is no template of missions with this id."),
    ErrorCode("schedule_not_found", 404, "There is no schedule of missions with this id."),
    ErrorCode("schedule_missed", None, "Of a schedule: no gateway could queue its mission within an hour."),
    ErrorCode("still_running", None, "Of a schedule: its last mission had not ended, so that it queued none."),
    ErrorCode("step_timeout", None, "Of a step: it took longer than its `timeout_s`."),
    ErrorCode("not_sent", None, "Of a step: its goal could not be sent within 23 hours."),
    ErrorCode("goal_canceled", None, "Of a step: its goal was canceled, and not by the mission."),
    ErrorCode("low_battery", None, "Of a step: it was left, so that its robot charges first; it begins again."),
    ErrorCode("off_charger", None, "Of a mission's break for the battery: the docked robot was discharging."),
    ErrorCode("step_interrupted", None, "Of a step: the gateway ended during its call or its message."),
)
