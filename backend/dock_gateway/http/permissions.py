"""Which role each request and each command needs, and how limits apply to it. What is not listed here is refused.

Routes by their names. All GET routes need VIEWER unless they are listed.
"""

from collections.abc import Collection
from enum import Enum, auto

from dock_gateway.core.grant import Role

# Requests that need no login: health checks, and the login itself.
PUBLIC = frozenset({"healthz", "readyz", "get_session", "log_in", "log_out", "begin_login", "finish_login"})

ROUTES: dict[str, Role] = {
    # Streams
    "feedback": Role.VIEWER,
    "socket": Role.VIEWER,
    "echo_topic": Role.VIEWER,
    # Every user may stop a robot. Only a supervisor may release the stop.
    "stop": Role.VIEWER,
    "release_stop": Role.SUPERVISOR,
    "issue_ticket": Role.VIEWER,
    # Goals
    "dock": Role.OPERATOR,
    "undock": Role.OPERATOR,
    "send_action_goal": Role.OPERATOR,
    "cancel_goal": Role.OPERATOR,
    "cancel_undock_goal": Role.OPERATOR,
    "cancel_any_goal": Role.OPERATOR,
    "cancel_action_goal": Role.OPERATOR,
    "add_note": Role.OPERATOR,
    "delete_note": Role.OPERATOR,
    "replace_tags": Role.OPERATOR,
    # Robots
    "acknowledge": Role.OPERATOR,
    "withdraw_acknowledgement": Role.OPERATOR,
    "label_robot": Role.SUPERVISOR,
    "calibrate_dock": Role.SUPERVISOR,
    "reset_simulator": Role.OPERATOR,
    "place_robot": Role.OPERATOR,
    "switch_fault": Role.OPERATOR,
    # A battery state that is published by hand ends goals, and keeps robots from docking.
    "publish_battery": Role.SUPERVISOR,
    "start_publisher": Role.SUPERVISOR,
    "stop_publisher": Role.SUPERVISOR,
    # Automatic docking and webhooks; the address of a webhook is often a secret itself.
    "replace_rule": Role.SUPERVISOR,
    "remove_rule": Role.SUPERVISOR,
    "list_webhooks": Role.SUPERVISOR,
    "list_deliveries": Role.SUPERVISOR,
    "replace_webhook": Role.SUPERVISOR,
    "remove_webhook": Role.SUPERVISOR,
    "test_webhook": Role.SUPERVISOR,
    # The own login
    "change_password": Role.VIEWER,
    "log_out_everywhere": Role.VIEWER,
    # Users and tokens
    "list_users": Role.ADMIN,
    "put_user": Role.ADMIN,
    "remove_user": Role.ADMIN,
    "end_sessions": Role.ADMIN,
    "list_people": Role.ADMIN,
    "end_person_sessions": Role.ADMIN,
    "list_tokens": Role.ADMIN,
    "create_token": Role.ADMIN,
    "revoke_token": Role.ADMIN,
    # The audit log
    "list_audit": Role.ADMIN,
    "export_audit": Role.ADMIN,
}

# The audit log has every request that is not a GET, and these. They hand out much at once, or say who did what.
AUDITED_READS = frozenset({"export_goals", "export_goal", "list_audit", "export_audit", "finish_login"})
# The commands that it leaves out, as they change nothing.
UNAUDITED_COMMANDS = frozenset({"subscribe", "unsubscribe", "ping"})
# The requests and commands whose entry is stored before they are answered, if they succeed.
STORED_FIRST = frozenset(
    {
        "log_in",
        "finish_login",
        "log_out",
        "log_out_everywhere",
        "change_password",
        "put_user",
        "remove_user",
        "end_sessions",
        "end_person_sessions",
        "create_token",
        "revoke_token",
        "release_stop",
    }
)

# The commands of `/ws`.
COMMANDS: dict[str, Role] = {
    "subscribe": Role.VIEWER,
    "unsubscribe": Role.VIEWER,
    "ping": Role.VIEWER,
    "stop": Role.VIEWER,
    "release_stop": Role.SUPERVISOR,
    "send_goal": Role.OPERATOR,
    "cancel_goal": Role.OPERATOR,
    "publish_battery": Role.SUPERVISOR,
    "stop_publishing": Role.SUPERVISOR,
}


# Requests and commands that send a goal.
SENDING = frozenset({"dock", "undock", "send_action_goal", "send_goal"})


class Scope(Enum):
    """What a request or a command is about, which the user's grant has to include."""

    ANY = auto()  # nothing that a grant is limited to
    LISTED = auto()  # what the grant includes: the route leaves out the rest
    ROBOT = auto()  # the robot in `robot`; the configured one if none is named
    ROBOTS = auto()  # that robot and those below it: of `/`, every robot
    DOCK = auto()  # its docking action
    UNDOCK = auto()  # its undocking action
    ACTION = auto()  # the action in `name`
    GOAL = auto()  # the action of the goal in `goal_id`
    NEW_GOAL = auto()  # the action in `action`, or the docking action of `robot`
    ALERT = auto()  # the robot of the alert in `alert_id`
    TOPIC = auto()  # the topic in `name` or `topic`
    EVERY = auto()  # every robot


# What is not listed here is about every robot.
SCOPES: dict[str, Scope] = {
    # Every user may stop every robot.
    "stop": Scope.ANY,
    "issue_ticket": Scope.ANY,
    "list_interfaces": Scope.ANY,
    "get_interface": Scope.ANY,
    "list_tags": Scope.ANY,
    "change_password": Scope.ANY,
    "log_out_everywhere": Scope.ANY,
    # Lists and streams
    "feedback": Scope.LISTED,
    "socket": Scope.LISTED,
    "list_all_goals": Scope.LISTED,
    "export_goals": Scope.LISTED,
    "statistics": Scope.LISTED,
    "list_actions": Scope.LISTED,
    "list_robots": Scope.LISTED,
    "list_alerts": Scope.LISTED,
    "list_decisions": Scope.LISTED,
    "list_rules": Scope.LISTED,
    "get_graph": Scope.LISTED,
    # Robots
    "get_stop": Scope.ROBOT,
    "release_stop": Scope.ROBOTS,
    "get_battery": Scope.ROBOT,
    "battery_history": Scope.ROBOT,
    "publish_battery": Scope.ROBOT,
    "get_publisher": Scope.ROBOT,
    "start_publisher": Scope.ROBOT,
    "stop_publisher": Scope.ROBOT,
    "list_docks": Scope.DOCK,
    "get_calibration": Scope.ROBOT,
    "calibrate_dock": Scope.ROBOT,
    "get_simulator": Scope.ROBOT,
    "reset_simulator": Scope.ROBOT,
    "place_robot": Scope.ROBOT,
    "switch_fault": Scope.ROBOT,
    "acknowledge": Scope.ALERT,
    "withdraw_acknowledgement": Scope.ALERT,
    # Actions
    "dock": Scope.DOCK,
    "list_goals": Scope.DOCK,
    "undock": Scope.UNDOCK,
    "list_undock_goals": Scope.UNDOCK,
    "get_action": Scope.ACTION,
    "send_action_goal": Scope.ACTION,
    "list_action_goals": Scope.ACTION,
    # Goals
    "get_goal": Scope.GOAL,
    "get_undock_goal": Scope.GOAL,
    "get_any_goal": Scope.GOAL,
    "get_action_goal": Scope.GOAL,
    "cancel_goal": Scope.GOAL,
    "cancel_undock_goal": Scope.GOAL,
    "cancel_any_goal": Scope.GOAL,
    "cancel_action_goal": Scope.GOAL,
    "goal_events": Scope.GOAL,
    "undock_events": Scope.GOAL,
    "dock_events": Scope.GOAL,
    "action_events": Scope.GOAL,
    "goal_history": Scope.GOAL,
    "export_goal": Scope.GOAL,
    "list_notes": Scope.GOAL,
    "add_note": Scope.GOAL,
    "delete_note": Scope.GOAL,
    "replace_tags": Scope.GOAL,
    # Topics
    "echo_topic": Scope.TOPIC,
    "get_topic": Scope.TOPIC,
    # The rest of the API is about every robot.
    "metrics": Scope.EVERY,
    "label_robot": Scope.EVERY,
    "replace_rule": Scope.EVERY,
    "remove_rule": Scope.EVERY,
    "list_webhooks": Scope.EVERY,
    "list_deliveries": Scope.EVERY,
    "replace_webhook": Scope.EVERY,
    "remove_webhook": Scope.EVERY,
    "test_webhook": Scope.EVERY,
    "list_users": Scope.EVERY,
    "put_user": Scope.EVERY,
    "remove_user": Scope.EVERY,
    "end_sessions": Scope.EVERY,
    "list_people": Scope.EVERY,
    "end_person_sessions": Scope.EVERY,
    "list_tokens": Scope.EVERY,
    "create_token": Scope.EVERY,
    "revoke_token": Scope.EVERY,
    "list_audit": Scope.EVERY,
    "export_audit": Scope.EVERY,
}

COMMAND_SCOPES: dict[str, Scope] = {
    "subscribe": Scope.LISTED,
    "unsubscribe": Scope.ANY,
    "ping": Scope.ANY,
    "stop": Scope.ANY,
    "release_stop": Scope.ROBOTS,
    "send_goal": Scope.NEW_GOAL,
    "cancel_goal": Scope.GOAL,
    "publish_battery": Scope.ROBOT,
    "stop_publishing": Scope.ROBOT,
}


def role_for(name: str, methods: Collection[str]) -> Role | None:
    """Return the role that a route needs; None if no role suffices.

    Args:
        name: The name of the route.
        methods: Its methods, or that of the request.
    """
    return ROUTES.get(name, Role.VIEWER if "GET" in methods or "HEAD" in methods else None)
