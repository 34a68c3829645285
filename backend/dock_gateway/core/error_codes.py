"""The list of all error codes of the gateway's core. Those of an extension and of the hub are in lists of their own.

A code has one status, which the class that is raised with it has, too. The table in docs/errors.md and `x-codes` of
the OpenAPI document are made of these lists.
"""

from typing import Any, NamedTuple


class ErrorCode(NamedTuple):
    """An error code.

    Attributes:
        name: The code; of a problem document, its member `code`.
        status: The HTTP status of an answer with it; None if it stands only within answers and events.
        meaning: When it occurs, in one sentence.
        page: The page of docs/ that says more, as in a link; empty if none does.
    """

    name: str
    status: int | None
    meaning: str
    page: str = ""

    def document(self) -> dict[str, Any]:
        """Return it as the OpenAPI document has it."""
        return {"code": self.name, "status": self.status, "description": self.meaning}


CORE = (
    ErrorCode("redirected", 307, "The path has no slash at its end; `Location` is without it."),
    ErrorCode("malformed_json", 400, "The body is not JSON, is not UTF-8, is nested too deeply, or is incomplete."),
    ErrorCode("malformed_cdr", 400, "A message in CDR does not have the form of its type."),
    ErrorCode("malformed_request", 400, "The request is not HTTP/1.1, or not a valid WebSocket handshake."),
    ErrorCode("tls_required", 400, "Plain HTTP on the port of a gateway with TLS.", "deployment.md#tls"),
    ErrorCode("not_authenticated", 401, "The gateway asks for a login, and there is none.", "access.md"),
    ErrorCode("invalid_token", 401, "The login has ended, or the token is not known, was revoked or has expired."),
    ErrorCode("invalid_login", 401, "The name or the password is wrong, or the user is disabled."),
    ErrorCode(
        "invalid_ticket", 401, "The ticket of a WebSocket is not known, was used or has expired: ask for another."
    ),
    ErrorCode(
        "invalid_identity",
        401,
        "At a site: who asks is not signed by its hub, or is signed for another request, or has expired.",
    ),
    ErrorCode("identity_reused", 401, "At a site: the same signed identity was received before."),
    ErrorCode("approval_expired", 403, "No person has answered the goal of an agent in time."),
    ErrorCode("approval_refused", 403, "A person has refused the goal of an agent."),
    ErrorCode(
        "host_not_allowed",
        403,
        "The host name is not in `DOCK_GATEWAY_ALLOWED_HOSTS`, or `Host` is not a name with a port.",
    ),
    ErrorCode(
        "not_allowed",
        403,
        "The limits of a user or a token do not include the robot, the action or the topic. With `settings`: the "
        "gateway's settings do not name the service, the topic or the node, and these lines would.",
        "access.md#limits",
    ),
    ErrorCode("not_through_hub", 403, "At a site: logins, and below the role `admin` webhooks, are not for its hub."),
    ErrorCode(
        "origin_not_allowed",
        403,
        "A browser page of another origin: another scheme, host or port; `Origin` twice; `Sec-Fetch-Site: cross-site` "
        "without `Origin`.",
    ),
    ErrorCode(
        "role_required",
        403,
        "The role does not suffice, and `role` is the one that does. Without `role`: the identity provider gives no "
        "role, or no valid limits.",
        "access.md",
    ),
    ErrorCode(
        "use_other_request",
        403,
        "A part of an action, a topic of stops, or a service that sets parameters: no setting allows it, and `use` is "
        "the request to send instead, such as `POST /stop`.",
        "graph.md",
    ),
    ErrorCode("wrong_password", 403, "The old password is wrong."),
    ErrorCode("action_not_found", 404, "The action has no server."),
    ErrorCode("alert_not_found", 404, "The alert does not exist, has ended, or the limits leave it out."),
    ErrorCode(
        "approval_not_found",
        404,
        "The goal does not wait any more: it was answered, has expired, or was dropped by a stop.",
    ),
    ErrorCode(
        "dock_not_found",
        404,
        "The robot's docking server does not have the dock; `docks` are those that it has.",
        "robots.md#docks",
    ),
    ErrorCode("extension_not_found", 404, "No extension of this name has a card for the dashboard."),
    ErrorCode("goal_not_found", 404, "There is no such goal, or the limits leave it out.", "access.md#limits"),
    ErrorCode("interface_not_found", 404, "The type is not installed; the detail says what to install."),
    ErrorCode("node_not_found", 404, "There is no such node on the ROS graph; the detail has similar names."),
    ErrorCode("not_found", 404, "There is nothing at this path."),
    ErrorCode("parameters_not_found", 404, "The node has no parameters that can be asked for."),
    ErrorCode(
        "robot_not_found",
        404,
        "There is no such robot. To dock or undock: `robots` lists those that can, and `settings` has lines that join "
        "the robot with a docking server.",
        "nav2.md#other-namespaces",
    ),
    ErrorCode("service_not_found", 404, "There is no such service on the ROS graph; the detail has similar names."),
    ErrorCode("session_not_found", 404, "The login has ended."),
    ErrorCode("token_not_found", 404, "There is no token with this id."),
    ErrorCode("topic_not_found", 404, "There is no such topic on the ROS graph; the detail has similar names."),
    ErrorCode("user_not_found", 404, "There is no user of this name."),
    ErrorCode("method_not_allowed", 405, "`Allow` lists the methods of the path; `OPTIONS` answers 204 with the same."),
    ErrorCode("request_timeout", 408, "The head or the body did not arrive within 10 s."),
    ErrorCode("calibration_refused", 409, "The docking server did not calibrate the dock; the detail is its reason."),
    ErrorCode("cancel_rejected", 409, "The action server refuses to cancel."),
    ErrorCode("display_name_taken", 409, "Another robot has this display name, or has it as its namespace."),
    ErrorCode(
        "dock_busy",
        409,
        "The action server did not accept the goal, as another one is running: `running_goal_id`, if the gateway knows "
        "it; `goal_id` is the one that was not accepted.",
    ),
    ErrorCode(
        "dock_occupied",
        409,
        "Another robot has the dock, or waits for it: `robot`, since `since_at`. The same goal may be sent later.",
    ),
    ErrorCode(
        "duplicate_action_server",
        409,
        "More than one action server serves the action, and each would move the robot. With "
        "`DOCK_GATEWAY_ALLOW_DUPLICATE_SERVERS` the goal is sent anyway.",
    ),
    ErrorCode("goal_rejected", 409, "The action server did not accept the goal; `goal_id`."),
    ErrorCode("goal_terminal", 409, "The goal has ended already; `goal_id`."),
    ErrorCode("idempotency_key_reused", 409, "The same user has used the same key with another goal."),
    ErrorCode("last_admin", 409, "No admin would be left."),
    ErrorCode(
        "limit_reached",
        409,
        "As many are stored as there may be, of all users together; `limit` says how many. There may be 2,000 labels "
        "of robots, 100 notes of a goal, 50 rules, 20 webhooks, 500 tokens, 200 users.",
    ),
    ErrorCode("parameters_refused", 409, "The node refuses the parameters, with its reason; none was set."),
    ErrorCode("robots_claimed", 409, "Another gateway on the same database serves the robots.", "postgresql.md#shares"),
    ErrorCode("stop_latched", 409, "The robot was stopped, and the stop has not been released.", "stop.md"),
    ErrorCode("stopped", 409, "A stop arrived before the goal was sent, so the goal was not sent.", "stop.md"),
    ErrorCode("subscription_exists", 409, "This socket already has a subscription with this id."),
    ErrorCode("token_exists", 409, "There is a token of this name."),
    ErrorCode(
        "topic_in_use",
        409,
        "The gateway itself uses the topic with another type, or will: topics of stops, velocities, batteries and "
        "actions have their types, whether the robot is there or not.",
    ),
    ErrorCode("type_conflict", 409, "The topic is subscribed to with another type."),
    ErrorCode("user_changed", 409, "Other gateways change the user at the same time."),
    ErrorCode("user_exists", 409, "There is a user of this name."),
    ErrorCode("user_required", 409, "A password and sessions are for users, not for tokens."),
    ErrorCode(
        "wrong_topic_type",
        409,
        "The battery topic is of another type on the ROS graph, so nothing is published there; the alert names it.",
    ),
    ErrorCode(
        "body_too_large",
        413,
        "Over 1 MB, or more than 20,000 objects and arrays; a message in CDR with more than 10,000 nested messages and "
        "texts.",
    ),
    ErrorCode(
        "unsupported_media_type",
        415,
        "The body's `Content-Type` is not accepted as JSON, or it has a `Content-Encoding`, such as gzip.",
    ),
    ErrorCode(
        "changed_meanwhile",
        412,
        "The change depends on a version, and someone else was faster: read it again, then decide.",
        "api.md#changes-by-several-people",
    ),
    ErrorCode(
        "served_elsewhere",
        421,
        "Another gateway serves the robot; `gateway` says where it is, if that is known.",
        "postgresql.md#shares",
    ),
    ErrorCode("invalid_field", 422, "Fields are invalid; `errors` has their paths, the expected types and ranges."),
    ErrorCode(
        "upgrade_required",
        426,
        "A `GET` of a WebSocket's path that is no WebSocket: mostly a reverse proxy does not pass on `Upgrade` and "
        "`Connection`, or speaks HTTP/1.0 to the gateway.",
        "configuration.md#behind-a-reverse-proxy",
    ),
    ErrorCode(
        "too_many_approvals",
        429,
        "3 goals of this agent already wait for a person (without logins, 8 of this address), or 10 of all agents.",
    ),
    ErrorCode(
        "too_many_calls",
        429,
        "You have 8 calls of services in progress, 4 of this one, or 3 requests for parameters (without logins, your "
        "address has 24, 6 or 6); or all users together have 32, 8 or 8, of which 8, 2 and 2 are reserved.",
        "configuration.md#shares-of-users",
    ),
    ErrorCode(
        "too_many_connections",
        429,
        "A WebSocket is refused because only the connections reserved for short requests are left: your address has "
        "its share, or all clients together.",
    ),
    ErrorCode(
        "too_many_exports", 429, "You have your share of exports in progress.", "configuration.md#shares-of-users"
    ),
    ErrorCode(
        "too_many_goals", 429, "You have sent your share of goals per minute.", "configuration.md#shares-of-users"
    ),
    ErrorCode(
        "too_many_logins",
        429,
        "Several logins have failed; `Retry-After` and `retry_after` are the seconds to wait. Without `retry_after`, "
        "too many are in progress: 20 of your address (of a user who is logged in, 10) or 100 of all, of which 10 are "
        "reserved; with the identity provider 5 of your address or 20 of all.",
    ),
    ErrorCode(
        "too_many_requests",
        429,
        "Too many goals wait for the answer of an action server, too many topics are subscribed to or watched, or too "
        "many cameras. The detail says whether it is your limit, that of this connection or that of all users.",
        "configuration.md#shares-of-users",
    ),
    ErrorCode(
        "too_many_streams",
        429,
        "You have your share of streams, or all that are not reserved are in use.",
        "configuration.md#shares-of-users",
    ),
    ErrorCode(
        "too_much_input",
        429,
        "The body is over 16 kB while clients at your address are sending more than 6 MB, or all clients together more "
        "than 8 MB; or 32 large messages wait to be read.",
    ),
    ErrorCode(
        "header_too_large",
        431,
        "The head of the request is over 64 kB or has more than 128 lines, or a line of a WebSocket request is over "
        "8 kB.",
    ),
    ErrorCode("internal_error", 500, "A bug in the gateway; its log has the details."),
    ErrorCode("calibration_unavailable", 501, "The robot's docking server does not offer `calibrate_dock`."),
    ErrorCode("extension_failed", 501, "It belongs to an extension that could not be opened: the alert says why."),
    ErrorCode(
        "interface_not_installed",
        501,
        "The action, the topic or the service cannot be used; the detail says why, usually what to install.",
    ),
    ErrorCode("not_supported", 501, "An operation of the protocol that the gateway does not have."),
    ErrorCode("response_too_large", 502, "The response of a service is larger than `DOCK_GATEWAY_MAX_MESSAGE_BYTES`."),
    ErrorCode("site_failed", 502, "At a hub: a site has given up a request, or its answer is not valid."),
    ErrorCode("site_refused", 502, "At a hub: a site does not accept this hub; `reason` says why."),
    ErrorCode("action_server_unavailable", 503, "No action server within 2 s."),
    ErrorCode("action_server_unresponsive", 503, "The action server is there and does not answer: nothing was sent."),
    ErrorCode("broker_unavailable", 503, "There is no connection to a NATS server."),
    ErrorCode("docks_unavailable", 503, "The docking server's node does not answer for its parameters within 6 s."),
    ErrorCode(
        "history_unavailable",
        503,
        "The history database does not answer, so the request cannot be answered; or a new goal can be stored neither "
        "there nor on disk.",
        "history.md",
    ),
    ErrorCode("message_too_large", 503, "A message is larger than the NATS server takes now."),
    ErrorCode("no_responder", 503, "Nothing answers at the NATS server."),
    ErrorCode("ros_unavailable", 503, "The ROS thread is down; for a stop: zero velocity could not be published."),
    ErrorCode("service_gone", 503, "The server of a service has left during the call: it may have carried it out."),
    ErrorCode("service_unavailable", 503, "The server of a service is not reached."),
    ErrorCode(
        "shutting_down",
        503,
        "The gateway is about to close: no new stream is opened. Or it closed before it had answered: what was asked "
        "for may have been done, so repeat it with the same `Idempotency-Key`.",
    ),
    ErrorCode("site_unreachable", 503, "At a hub: the site is not connected; nothing was sent to it."),
    ErrorCode(
        "action_server_timeout",
        504,
        "A goal was sent, and not answered within 5 s; if the server accepts it later, the gateway cancels it at once. "
        "Or it did not answer a request to cancel, which is repeated.",
        "errors.md#after-a-504",
    ),
    ErrorCode("calibration_timeout", 504, "The docking server did not answer within 18 s."),
    ErrorCode("parameters_timeout", 504, "A node did not answer for its parameters; they may still be set."),
    ErrorCode("service_timeout", 504, "A service did not answer in time; the call may still be carried out."),
    ErrorCode(
        "site_timeout",
        504,
        "At a hub: the site has not begun with the request within 10 s, or shows no sign of life; whether it has acted "
        "is not known. `Idempotency-Key` repeats the request safely.",
    ),
    ErrorCode("action_server_lost", None, "Of a goal: the action server is gone, or does not know the goal any more."),
    ErrorCode("canceled", None, "Of a goal: it was canceled while the action server could not be reached."),
    ErrorCode("goal_aborted", None, "Of a goal: the action server gave up and gave no reason."),
    ErrorCode(
        "latch_not_published",
        None,
        "In `failed` of a stop: the robot was sent zero velocity, but its `stop_latched` is of another type, so its "
        "nodes do not hear of the stop.",
    ),
    ErrorCode("result_too_large", None, "Of a goal: its result is larger than `DOCK_GATEWAY_MAX_MESSAGE_BYTES`."),
    ErrorCode("result_unavailable", None, "Of a goal: it has ended, but the action server did not send its result."),
    ErrorCode(
        "stop_not_persisted", None, "The `warning` of a stop: a restart of the gateway would lose the stop.", "stop.md"
    ),
    ErrorCode(
        "goal_unconfirmed", None, "Of a goal: the gateway restarted, and the server may not have received the goal."
    ),
)
# What a goal's error says of an action server that uses a code of ours for something of its own.
OF_SERVER = "server_"
# Codes that mean the same at a server and here.
SHARED = frozenset({"dock_busy", "goal_aborted", "goal_rejected", "stop_latched"})
NAMES = frozenset(code.name for code in CORE)


def code_of_server(name: str) -> str:
    """Return the code of an action server's error as a goal's error has it: in lower case, and none of ours."""
    code = name.lower()
    return f"{OF_SERVER}{code}" if code in NAMES and code not in SHARED else code
