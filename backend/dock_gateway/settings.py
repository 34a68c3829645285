"""The settings, each an environment variable `DOCK_GATEWAY_…` or an option of the command line."""

import difflib
import os
import re
from collections.abc import Iterable
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Annotated, Literal, Self, TypeVar

import platformdirs
from pydantic import Field, model_validator
from pydantic_settings import BaseSettings, SettingsConfigDict

from dock_gateway.setting_types import (
    LOOPBACK_HOSTS,
    ActionType,
    Algorithms,
    Days,
    ExtensionNames,
    HostNames,
    Issuer,
    ListensOn,
    Megabytes,
    Namespace,
    Networks,
    NodeName,
    OptionalFile,
    OptionalSecret,
    OptionalText,
    OptionalTopic,
    Origins,
    OwnNames,
    Patterns,
    Robots,
    RoleNames,
    Seconds,
    Topic,
    Topics,
    own_names,
)

PREFIX = "DOCK_GATEWAY_"
# Variables of the commands that are HTTP clients.
OF_CLIENTS = {"URL", "TOKEN", "CLIENT_CERT"}
# What Kubernetes sets in each container for a service that is called dock-gateway.
OF_LINKS = re.compile("SERVICE_|PORT_[0-9]")


def scope() -> str:
    """The robots within reach: the ROS domain, and whether only those of this machine.

    Robots of another scope are other robots: what the gateway keeps in the user's data directory has this in its name.
    """
    local = "-localhost" if os.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE") == "LOCALHOST" else ""
    return f"{os.environ.get('ROS_DOMAIN_ID') or 0}{local}"


def data_file(name: str) -> Path:
    """A path in the user's data directory."""
    return platformdirs.user_data_path("dock-gateway", appauthor=False) / name


def unknown_variables(environment: Iterable[str], fields: Iterable[str]) -> list[str]:
    """Return a sentence for each variable that looks like a setting but is none, with a similar setting.

    Args:
        environment: Names of variables.
        fields: The settings.
    """
    settings = [name.upper() for name in fields]
    sentences = []
    for variable in sorted(environment):
        name = variable.upper().removeprefix(PREFIX)
        if not variable.upper().startswith(PREFIX) or name in OF_CLIENTS or name in settings or OF_LINKS.match(name):
            continue
        similar = difflib.get_close_matches(name, settings, n=1, cutoff=0.7)
        hint = "".join(f". Did you mean {PREFIX}{one}?" for one in similar)
        sentences.append(f"{variable} is not a setting and has no effect{hint}")
    return sentences


class ExtensionSettings(BaseSettings):
    """The base of the settings of an extension, which the gateway's settings have, too."""

    model_config = SettingsConfigDict(env_prefix=PREFIX, frozen=True)

    def find_fault(self) -> str | None:
        """Return why a gateway cannot start with them, such as a file that cannot be read; None if it can."""


S = TypeVar("S", bound=ExtensionSettings)


class Settings(BaseSettings):
    """The gateway's settings, fixed once it runs. docs/configuration.md lists them; a test keeps the list complete."""

    model_config = SettingsConfigDict(env_prefix=PREFIX, frozen=True, extra="forbid")

    host: str = Field("127.0.0.1", description="Address to listen on. `0.0.0.0` opens the gateway to the network.")
    port: Annotated[int, ListensOn()] = Field(
        8000, ge=0, le=65535, description="Port to listen on; 0 selects a free port."
    )
    allowed_hosts: HostNames = Field(
        (),
        description="Host names that requests may be addressed to, such as `robot.local`, separated by commas; `*` "
        "for any. Loopback names and IP addresses are always allowed.",
    )
    allowed_origins: Origins = Field(
        (),
        description="Origins of web pages that may use the gateway besides its own dashboard, "
        "separated by commas (`https://ops.example.com`); `*` for any.",
    )
    extensions: ExtensionNames = Field(
        (),
        description="Extensions of other distributions that are loaded, separated by commas; only as a variable: "
        "[write-an-extension.md](write-an-extension.md).",
    )
    log_level: str = Field(
        "info",
        pattern="^(debug|info|warning|error)$",
        description="Log level. At most 20 similar lines are logged in 10 s and the rest are counted, except with "
        "`debug`.",
    )
    log_format: Literal["human", "json"] = Field(
        "human", description="Format of log lines: `human`, or `json` for a log collector: [logs.md](logs.md)."
    )
    authentication: bool = Field(
        False,
        description="Whether requests need a login or a token: [access.md](access.md).",
    )
    approval_timeout: Seconds = Field(
        60.0,
        description="Seconds that an agent's goal to a real robot waits for a person to allow it; then it is refused.",
    )
    insecure_open: bool = Field(
        False,
        description="Whether the gateway may listen on other than loopback addresses without `authentication`: then "
        "everyone who reaches it can move the robots.",
    )
    published_on: str = Field(
        "",
        description="In a container: the address of the host on which its port is published. It takes the place of "
        "`HOST` in deciding whether the gateway is open to a network.",
    )
    tls_cert: OptionalFile = Field(
        None,
        description="PEM file with the gateway's certificate and its intermediates. With it, the gateway speaks only "
        "TLS: [deployment.md](deployment.md#tls).",
    )
    tls_key: OptionalFile = Field(
        None, description="PEM file with the private key of `TLS_CERT`, without a passphrase."
    )
    tls_client_ca: OptionalFile = Field(
        None,
        description="PEM file with certificate authorities. Only clients with a certificate of theirs can connect.",
    )
    oidc_issuer: Issuer = Field(
        None,
        description="Issuer of the OpenID Connect provider where people log in, such as "
        "`https://login.example.com/realms/site`: [single_sign_on.md](extensions/single_sign_on.md).",
    )
    oidc_client_id: OptionalText = Field(
        None,
        description="The gateway's client id at the provider, for people who use the dashboard. Empty: only services.",
    )
    oidc_client_secret: OptionalSecret = Field(
        None,
        description="The secret of that client; empty for a public client. Options can be seen by others.",
    )
    oidc_audience: OptionalText = Field(
        None,
        description="The audience (`aud`) of JWT access tokens for this gateway, such as `https://robots.example.com`. "
        "Empty: none are accepted.",
    )
    oidc_name: str = Field(
        "", max_length=40, description="What the login page calls the provider. Empty: the host name of the issuer."
    )
    oidc_scopes: str = Field(
        "openid profile",
        pattern="^[!#-\\[\\]-~]+( [!#-\\[\\]-~]+)*$",
        description="What the dashboard asks the provider for, separated by spaces; `openid` is needed.",
    )
    oidc_algorithms: Algorithms = Field(
        ("RS256", "PS256", "ES256", "EdDSA", "Ed25519"),
        description="Algorithms of signatures that are accepted from the provider, separated by commas.",
    )
    oidc_name_claim: str = Field(
        "preferred_username",
        min_length=1,
        description="The claim with the name of a person or a service; `sub` is used where it is missing. It has to be "
        "one that people cannot change themselves.",
    )
    oidc_role_claim: str = Field(
        "roles",
        min_length=1,
        description="The claim with roles or groups: a text or a list. `realm_access.roles` is a claim in a claim.",
    )
    oidc_roles: RoleNames = Field(
        (),
        description="The role of each value of that claim: `robot-ops=operator,robot-admins=admin`. The highest "
        "counts; who has none of the values has no access.",
    )
    oidc_robots_claim: OptionalText = Field(
        None,
        description="The claim with the robots of a person or a service: a list of namespaces such as `/hall_a/*`. "
        "Without a valid one there is no access, but for admins. Empty: every robot.",
    )
    oidc_actions_claim: OptionalText = Field(None, description="The claim with the actions, likewise.")
    oidc_topics_claim: OptionalText = Field(None, description="The claim with the topics, likewise.")
    oidc_session_hours: float = Field(
        12.0, gt=0, le=720, description="Hours after which a login with the provider ends at the latest."
    )
    trusted_proxies: Networks = Field(
        (),
        description="IP addresses and networks (`10.0.0.0/8`) of reverse proxies, separated by commas: "
        "`127.0.0.1,::1` for one on this machine. Only their `X-Forwarded-Proto` and `X-Forwarded-For` are believed.",
    )
    dashboard_dir: Path | None = Field(
        None,
        description="Folder of the built dashboard. Empty: the installed one, or `frontend/dist` in a checkout.",
    )

    node_name: NodeName = Field("dock_gateway", description="Name of the gateway's ROS node.")
    namespace: Namespace = Field("", description="ROS namespace of the robot, such as `/robot1`.")
    robots: Robots = Field(
        (),
        description="Robots that this gateway serves: namespaces such as `/robot1` or `/fleet_a/*`, separated by "
        "commas. Empty: every robot. Other gateways serve the others: [postgresql.md](postgresql.md#shares).",
    )
    dock_action: OptionalTopic = Field(
        "",
        description="The action behind `/dock`, relative to the namespace. Empty: picked for each robot from the ROS "
        "graph ([nav2.md](nav2.md)).",
    )
    dock_action_type: ActionType = Field("", description="The type of that action. Empty: as on the ROS graph.")
    undock_action: OptionalTopic = Field(
        "", description="The action behind `/undock`, relative to the namespace. Empty: as for `DOCK_ACTION`."
    )
    undock_action_type: ActionType = Field("", description="The type of that action. Empty: as on the ROS graph.")
    dock_actions: OwnNames = Field(
        (),
        description="Docking actions of single robots, separated by commas: `/robot1=/docking/dock_robot`. For docking "
        "servers that are not in the namespace of their robot: [nav2.md](nav2.md#other-namespaces).",
    )
    undock_actions: OwnNames = Field((), description="Undocking actions of single robots, likewise.")
    battery_topics: OwnNames = Field(
        (), description="Battery topics of single robots, likewise: `/robot1=/power/battery_status`."
    )
    default_dock: str = Field(
        "",
        max_length=200,
        description="The dock that a `POST /dock` without `dock_id` means, for action servers that know docks by name "
        "([nav2.md](nav2.md)).",
    )
    battery_topic: Topic = Field("battery_status", description="Topic of `sensor_msgs/BatteryState`.")
    cmd_vel_topic: Topic = Field(
        "cmd_vel",
        description="Topic of `geometry_msgs/Twist` or `TwistStamped`, whichever the robot's base subscribes to. "
        "`/stop` publishes zero velocity on it.",
    )
    stop_topic: Topic = Field("stop_latched", description="Topic of `std_msgs/Bool`: whether a stop is latched.")
    stop_topics: Topics = Field(
        (),
        description="More topics of `std_msgs/Bool`, separated by commas, such as that of an emergency stop: `true` on "
        "one of them stops the robot.",
    )
    diagnostics_topic: Topic = Field(
        "/diagnostics",
        description="Topic of `diagnostic_msgs/DiagnosticArray`, on which action servers report why a goal ended.",
    )

    allow_duplicate_servers: bool = Field(
        False,
        description="Whether goals are sent to an action that has more than one server. Each of them executes every "
        "goal.",
    )
    allow_shared_servers: bool = Field(
        False,
        description="Whether a node that serves the docking actions of several robots docks different robots. If not, "
        "they count as one robot by several names: automatic docking sends it no goals.",
    )
    publish: Patterns = Field(
        (),
        description="Topics that clients may publish on, separated by commas: `/battery_status`, or `/robot1/*`, where "
        "`*` stands for any text. Empty: none ([graph.md](graph.md)).",
    )
    call_services: Patterns = Field(
        (),
        description="Services that clients may call, likewise, besides those that only read, such as `get_parameters`. "
        "Name none that may move a robot unless that is meant.",
    )
    set_parameters: Patterns = Field(
        (), description="Nodes whose parameters supervisors may set, likewise. Everyone may read them."
    )
    server_wait: Seconds = Field(
        1.5, description="Seconds to wait for an action server to appear before a goal is refused (503)."
    )
    accept_timeout: Seconds = Field(
        5.0, description="Seconds that an action server may take to accept or reject a goal (504)."
    )
    cancel_timeout: Seconds = Field(
        5.0, description="Seconds that an action server may take to answer a cancel request (504)."
    )
    ping_interval: Seconds = Field(1.0, description="Seconds between two checks of an action server that answers.")
    stalled_after: Seconds = Field(
        3.0, description="Seconds without a message from the action server after which a running goal is `stalled`."
    )
    lost_after: Seconds = Field(
        8.0, description="Seconds without a message from the action server after which a running goal is `lost`."
    )
    command_timeout: float = Field(
        0.3,
        ge=0,
        le=60,
        description="Seconds without a command after which a robot that moves for a docking goal gets zero velocity: "
        "[stop.md](stop.md#commands-that-end). 0: never.",
    )
    battery_stale_after: Seconds = Field(
        2.0, description="Seconds without a message after which the battery state is stale."
    )
    forget_robot_after: float = Field(
        600.0,
        ge=0,
        description="Seconds after which a robot that has left the ROS graph is removed from `/robots`; 0: never. "
        "The configured robot is never removed.",
    )
    store_poses: bool = Field(
        True,
        description="Whether to store where a robot is while a goal on one of its actions runs, for the map of the "
        "goal's replay.",
    )
    low_battery: float = Field(
        0.2,
        ge=0,
        lt=1,
        description="Charge (0 to 1) below which a robot that is not charging raises an alert; 0: never.",
    )
    percentage_0_to_100: Robots = Field(
        (),
        description="Robots whose battery driver counts `percentage` from 0 to 100, not to 1: namespaces such as "
        "`/robot1` or `/hall_a/*`, separated by commas; `*` for all.",
    )
    charging_current_negative: Robots = Field(
        (),
        description="Robots whose battery driver counts a charging `current` as negative; as for "
        "`PERCENTAGE_0_TO_100`. It counts where `power_supply_status` is UNKNOWN.",
    )

    database_url: str = Field(
        "",
        pattern=r"^(memory:|sqlite:///.+|postgres(ql)?://.*)?$",
        description="URL of the history database: `postgresql://user@host/name`, `sqlite:////path/to/history.db`, or "
        "`memory:`. Empty: SQLite, `history-<ROS_DOMAIN_ID>.db` in the user's data directory, or "
        "`history-<ROS_DOMAIN_ID>-localhost.db` if discovery is limited to this machine.",
    )
    spool_path: Path | None = Field(
        None,
        description="Folder for goals while the database is not available. Empty: `spool-<ROS_DOMAIN_ID>` in the "
        "user's data directory, or `spool-<ROS_DOMAIN_ID>-localhost` if discovery is limited to this machine.",
    )
    stop_path: Path | None = Field(
        None,
        description="File that keeps latched stops across restarts. Empty: `stops-<ROS_DOMAIN_ID>.json` in the "
        "user's data directory, or `stops-<ROS_DOMAIN_ID>-localhost.json` if discovery is limited to "
        "this machine.",
    )
    history_queue: int = Field(
        10_000,
        ge=100,
        description="Maximum number of feedback and battery events that wait for the database. Beyond it, the oldest "
        "are dropped.",
    )
    retention_hours: float = Field(
        168.0,
        gt=0,
        le=8_760_000,
        description="Hours for which feedback and battery events are kept. Status and result events are kept as long "
        "as their goal.",
    )
    retention_mb: Megabytes = Field(
        256,
        description="Maximum size of the stored feedback and battery events, in megabytes. The oldest are deleted "
        "first.",
    )
    goal_retention_days: Days = Field(
        365.0,
        description="Days for which goals are kept, with their status and result events. Goals that have not ended "
        "are not deleted.",
    )
    goal_retention_mb: Megabytes = Field(
        1000,
        description="Maximum size of the stored goals with their status and result events, in megabytes. The oldest "
        "ended goals are deleted first.",
    )
    audit_retention_days: Days = Field(
        365.0,
        description="Days for which the entries of the audit log are kept.",
    )
    audit_max_entries: int = Field(
        1_000_000,
        ge=1000,
        description="Maximum number of entries of the audit log, about 0.6 kB each. The oldest are deleted first.",
    )

    max_actions: int = Field(
        1000,
        ge=2,
        description="Maximum number of actions on the ROS graph that the gateway serves, docking first. Each takes "
        "0.7 MB of memory.",
    )
    max_robots: int = Field(500, ge=1, description="Maximum number of robots that the gateway serves.")
    max_message_bytes: int = Field(
        1_000_000,
        ge=1024,
        description="Maximum size of a ROS message, in bytes. Larger feedback is dropped (`feedback_dropped`); a "
        "goal with a larger result ends without it (`result_too_large`).",
    )
    max_body_bytes: int = Field(1_000_000, ge=1024, description="Maximum size of a request body, in bytes (413).")
    body_timeout: Seconds = Field(10.0, description="Seconds that a client may take to send a body (408).")
    max_header_bytes: int = Field(
        65_536,
        ge=8192,
        le=1_000_000,
        description="Maximum size of a request's first line and headers together, in bytes (431).",
    )
    header_timeout: Seconds = Field(
        10.0, description="Seconds that a client may take to send the first line and headers of a request (408)."
    )
    max_connections: int = Field(
        4000,
        ge=32,
        description="Maximum number of connections; lower if the limit of open files does not leave 128 for other "
        "files.",
    )
    max_connections_per_address: int = Field(
        2000,
        ge=8,
        description="Maximum number of connections from one address. Behind a proxy, all clients have its address.",
    )
    max_frames_per_second: int = Field(
        1000,
        ge=10,
        description="Maximum number of frames per second on a WebSocket, including pings. Beyond it, the WebSocket "
        "is closed with 1008.",
    )
    max_frame_bytes_per_second: int = Field(
        4_000_000,
        ge=65_536,
        description="Maximum number of bytes per second on a WebSocket. Beyond it, the WebSocket is closed with 1008.",
    )
    max_pending_goals: int = Field(
        32,
        ge=1,
        description="Maximum number of goals of one action that wait for acceptance (429): "
        "[shares](configuration.md#shares-of-users).",
    )
    max_goals: int = Field(
        1000, ge=10, description="Maximum number of ended goals in the history `memory:`. The oldest are deleted first."
    )
    max_subscribers: int = Field(
        1000,
        ge=1,
        description="Maximum number of streams of all users together (429): "
        "[shares](configuration.md#shares-of-users).",
    )
    max_streams_per_user: int = Field(
        250, ge=1, description="Maximum number of streams of one user (429), with `authentication`."
    )
    max_goals_per_minute: int = Field(
        600, ge=1, description="Maximum number of goals of one user in a minute (429), with `authentication`."
    )
    max_exports_per_user: int = Field(
        2, ge=1, description="Maximum number of simultaneous exports of one user (429), with `authentication`."
    )
    subscriber_queue: int = Field(
        256,
        ge=1,
        description="Maximum number of feedback events that wait for a slow subscriber. Beyond it, the oldest are "
        "dropped.",
    )
    subscriber_timeout: Seconds = Field(
        30.0, description="Seconds after which a subscriber that does not read is disconnected."
    )
    heartbeat_interval: Seconds = Field(5.0, description="Seconds between heartbeats on a stream.")

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.stalled_after <= self.ping_interval:
            raise ValueError("ping_interval must be shorter than stalled_after")
        if self.lost_after <= self.stalled_after:
            raise ValueError("lost_after must be longer than stalled_after")
        ports = [port for port in self.ports.values() if port]
        if len(set(ports)) < len(ports):
            raise ValueError(f"{', '.join(self.ports)} must be different ports")
        if (self.tls_cert is None) != (self.tls_key is None):
            raise ValueError("tls_cert and tls_key belong together: set both or neither")
        if self.tls_client_ca is not None and not self.tls:
            raise ValueError("tls_client_ca needs tls_cert and tls_key")
        if self.authentication and self.database_url == "memory:":
            raise ValueError("authentication needs a database for users and tokens: the history `memory:` keeps none")
        return self

    @model_validator(mode="after")
    def _check_robots(self) -> Self:
        if not self.robots:
            return self
        name = f"/{self.namespace.strip('/')}"
        if name != "/" and not _named(name, (*self.robots, *(f"{each.rstrip('/')}/*" for each in self.robots))):
            raise ValueError(f"namespace {name} is none of robots, which are {', '.join(self.robots)}")
        if self.dock_action.startswith("/") or self.undock_action.startswith("/"):
            raise ValueError(
                "robots does not go together with an absolute dock_action or undock_action, which is that of every "
                "robot: name those of single robots in dock_actions and undock_actions"
            )
        return self

    @model_validator(mode="after")
    def _check_oidc(self) -> Self:
        if self.oidc_issuer is None:
            if needless := sorted(
                name for name in self.model_fields_set if name.startswith("oidc_") and getattr(self, name)
            ):
                raise ValueError(f"{needless[0]} needs oidc_issuer")
            return self
        if not self.authentication:
            raise ValueError("oidc_issuer needs authentication: without it no one logs in")
        if self.oidc_client_id is None and self.oidc_audience is None:
            raise ValueError("oidc_issuer needs oidc_client_id for people, or oidc_audience for services, or both")
        if self.oidc_client_id is None and self.oidc_client_secret is not None:
            raise ValueError("oidc_client_secret needs oidc_client_id")
        if self.oidc_client_id == self.oidc_audience:
            raise ValueError(
                "oidc_audience must not be oidc_client_id: the ID tokens of people would be accepted as access tokens"
            )
        if "openid" not in self.oidc_scopes.split():
            raise ValueError("oidc_scopes needs openid")
        if not self.oidc_roles:
            raise ValueError("oidc_issuer needs oidc_roles, such as robot-ops=operator: without it no one has a role")
        return self

    def of(self, kind: type[S]) -> S:
        """The settings of an extension: those that came with these, or else those of the environment."""
        return self if isinstance(self, kind) else kind()

    @property
    def ports(self) -> dict[str, int]:
        """The ports to listen on, by the names of their settings."""
        return {name: port for name, _ in self._listened() if (port := getattr(self, name)) is not None}

    @property
    def own_ports(self) -> dict[int, str]:
        """The ports that extensions have for themselves, each with the path where its WebSockets lead."""
        listened = ((getattr(self, name), mark.path) for name, mark in self._listened())
        return {port: path for port, path in listened if port is not None and path is not None}

    def _listened(self) -> list[tuple[str, ListensOn]]:
        fields = type(self).model_fields.items()
        return [(name, mark) for name, field in fields for mark in field.metadata if isinstance(mark, ListensOn)]

    @property
    def open_to(self) -> Literal["machine", "network"] | None:
        """The clients that need no login: the programs of this machine, or all clients on the network."""
        if self.authentication:
            return None
        return "machine" if (self.published_on or self.host) in LOOPBACK_HOSTS else "network"

    @property
    def tls(self) -> bool:
        """Whether the gateway speaks TLS."""
        return self.tls_cert is not None

    def own_file(self, name: str, suffix: str = "") -> Path:
        """A path of this gateway in the user's data directory: gateways with a share each may run on one machine."""
        share = re.sub(r"\W+", "-", ",".join(self.robots)).strip("-")[:60]
        return data_file(f"{name}-{scope()}{share and f'-{share}'}{suffix}")

    @property
    def stop_file(self) -> Path:
        """The file with latched stops."""
        return self.stop_path or self.own_file("stops", ".json")

    @property
    def database(self) -> str:
        """The URL of the history."""
        return self.database_url or f"sqlite:///{self.own_file('history', '.db')}"

    @property
    def spool_folder(self) -> Path:
        """The folder for goals that the database does not take at once."""
        return self.spool_path or self.own_file("spool")

    def counts_to_100(self, namespace: str) -> bool:
        """Whether the battery driver of a robot counts percentage to 100."""
        return _named(namespace, self.percentage_0_to_100)

    def charges_negative(self, namespace: str) -> bool:
        """Whether the battery driver of a robot counts a charging current as negative."""
        return _named(namespace, self.charging_current_negative)

    def battery_of(self, namespace: str) -> str:
        """The battery topic of a robot."""
        return own_names(self.battery_topics).get(namespace) or self.resolve(self.battery_topic, namespace)

    def resolve(self, name: str, namespace: str | None = None) -> str:
        """A ROS name as the graph has it: absolute, under the namespace (the configured one) where it was relative."""
        under = self.namespace if namespace is None else namespace
        return name if name.startswith("/") else f"/{under.strip('/')}/{name}".replace("//", "/")


def _named(namespace: str, patterns: tuple[str, ...]) -> bool:
    """Return whether a robot is one of those that a setting names."""
    return any(fnmatchcase(namespace, f"/{pattern.strip('/')}") for pattern in patterns)
