"""Which role each request and each command needs. What is not listed here is refused.

Routes by their names. All GET routes need VIEWER unless they are listed.
"""

from collections.abc import Collection

from dock_gateway.core.access import Role

# Requests that need no token: health checks, and the login itself.
PUBLIC = frozenset({"healthz", "readyz", "get_session", "log_in", "log_out"})

ROUTES: dict[str, Role] = {
    # Streams
    "feedback": Role.VIEWER,
    "socket": Role.VIEWER,
    "echo_topic": Role.VIEWER,
    # Every user may stop a robot. Only a supervisor may release the stop.
    "stop": Role.VIEWER,
    "release_stop": Role.SUPERVISOR,
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
    # Tokens
    "list_tokens": Role.ADMIN,
    "create_token": Role.ADMIN,
    "revoke_token": Role.ADMIN,
}

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


def role_for(name: str, methods: Collection[str]) -> Role | None:
    """Return the role that a route needs; None if no role suffices.

    Args:
        name: The name of the route.
        methods: Its methods, or that of the request.
    """
    return ROUTES.get(name, Role.VIEWER if "GET" in methods or "HEAD" in methods else None)
