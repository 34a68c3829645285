"""The settings, each an environment variable `DOCK_GATEWAY_…` or an option of the command line."""

import difflib
import os
import re
from collections.abc import Callable, Iterable
from fnmatch import fnmatchcase
from pathlib import Path
from typing import ClassVar, Literal, Self, TypeVar

import platformdirs
from pydantic import model_validator

from dock_gateway.setting_groups.access import AccessSettings
from dock_gateway.setting_groups.group import PREFIX, SettingsGroup, config_file, read_file
from dock_gateway.setting_groups.history import HistorySettings
from dock_gateway.setting_groups.limits import LimitSettings
from dock_gateway.setting_groups.one_robot import RobotTable
from dock_gateway.setting_groups.robots import RobotSettings
from dock_gateway.setting_groups.server import ServerSettings
from dock_gateway.setting_types import LOOPBACK_HOSTS, ListensOn

# Variables of the commands that are HTTP clients, and of the configuration file.
OTHERS = {"URL", "TOKEN", "CLIENT_CERT", "CONFIG"}
# It says which settings there are.
ONLY_A_VARIABLE = "extensions"
# The settings that no option has.
WITHOUT_OPTION = (ONLY_A_VARIABLE, "robots")
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


def log_file(name: str) -> Path:
    """A path in the user's log directory."""
    return platformdirs.user_log_path("dock-gateway", appauthor=False) / name


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
        if not variable.upper().startswith(PREFIX) or name in OTHERS or name in settings or OF_LINKS.match(name):
            continue
        hint = "".join(f". Did you mean {PREFIX}{one}?" for one in similar(name, settings))
        sentences.append(f"{variable} is not a setting and has no effect{hint}")
    return sentences


def find_file_fault(fields: Iterable[str]) -> str | None:
    """Return why the configuration file cannot be used: it is missing, or has a setting that there is not.

    Args:
        fields: The settings.
    """
    if (path := config_file()) is None:
        return None
    try:
        found = read_file(path)
    except ValueError as error:
        return str(error)
    settings = [*fields]
    if (unknown := next((name for name in found if name not in settings), None)) is not None:
        hint = "".join(f". Did you mean {one}?" for one in similar(unknown, settings))
        return f"{path}: {unknown} is not a setting{hint}"
    if ONLY_A_VARIABLE in found:
        return f"{path}: {ONLY_A_VARIABLE} can only be set as a variable, {PREFIX}{ONLY_A_VARIABLE.upper()}"
    return None


def similar(name: str, known: list[str]) -> list[str]:
    """Return the known name that is most like another, if one is."""
    return difflib.get_close_matches(name, known, n=1, cutoff=0.7)


class ExtensionSettings(SettingsGroup):
    """The base of the settings of an extension, which the gateway's settings have, too."""

    def find_fault(self) -> str | None:
        """Return why a gateway cannot start with them, such as a file that cannot be read; None if it can."""


S = TypeVar("S", bound=ExtensionSettings)
T = TypeVar("T")


# The last base comes first in the help.
class Settings(LimitSettings, HistorySettings, RobotSettings, AccessSettings, ServerSettings, SettingsGroup):
    """The gateway's settings, fixed once it runs. docs/configuration.md lists them; a test keeps the list complete.

    Attributes:
        many_sites: Whether the program is one dashboard for many sites, each below `/sites/{site}`.
    """

    many_sites: ClassVar[bool] = False

    @model_validator(mode="after")
    def _check(self) -> Self:
        ports = [port for port in self.ports.values() if port]
        if len(set(ports)) < len(ports):
            raise ValueError(f"{', '.join(self.ports)} must be different ports")
        if self.authentication and self.database_url == "memory:":
            raise ValueError("authentication needs a database for users and tokens: the history `memory:` keeps none")
        return self

    @model_validator(mode="after")
    def _check_robots(self) -> Self:
        if not self.serve_robots:
            return self
        name = f"/{self.namespace.strip('/')}"
        below = (f"{each.rstrip('/')}/*" for each in self.serve_robots)
        if name != "/" and not _named(name, (*self.serve_robots, *below)):
            raise ValueError(f"namespace {name} is none of serve_robots, which are {', '.join(self.serve_robots)}")
        if self.dock_action.startswith("/") or self.undock_action.startswith("/"):
            raise ValueError(
                "serve_robots does not go together with an absolute dock_action or undock_action, which is that of "
                "every robot: name those of single robots in robots"
            )
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
        share = re.sub(r"\W+", "-", ",".join(self.serve_robots)).strip("-")[:60]
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
        return self._first(namespace, lambda table: table.battery.percentage) == "0-100"

    def charges_negative(self, namespace: str) -> bool:
        """Whether the battery driver of a robot counts a charging current as negative."""
        return self._first(namespace, lambda table: table.battery.charging_current) == "negative"

    def default_dock_of(self, namespace: str) -> str:
        """The dock that a goal of a robot means if it names none; empty: none."""
        return self._first(namespace, lambda table: table.default_dock) or self.default_dock

    def own_actions(self, verb: str) -> dict[str, str]:
        """The actions that dock or undock single robots, by namespace."""
        actions = ((robot, getattr(table, f"{verb}_action")) for robot, table in self.robots.items())
        return {robot: name for robot, name in actions if name}

    @property
    def own_batteries(self) -> dict[str, str]:
        """The battery topics of single robots, by namespace."""
        return {robot: table.battery.topic for robot, table in self.robots.items() if table.battery.topic}

    def _first(self, namespace: str, read: Callable[[RobotTable], T | None]) -> T | None:
        """Return what a robot's own table says, or else the first pattern that says something."""
        patterns = (table for name, table in self.robots.items() if name != namespace and _named(namespace, (name,)))
        own = [self.robots[namespace]] if namespace in self.robots else []
        return next((value for table in (*own, *patterns) if (value := read(table))), None)

    def battery_of(self, namespace: str) -> str:
        """The battery topic of a robot."""
        return self.own_batteries.get(namespace) or self.resolve(self.battery_topic, namespace)

    def resolve(self, name: str, namespace: str | None = None) -> str:
        """A ROS name as the graph has it: absolute, under the namespace (the configured one) where it was relative."""
        under = self.namespace if namespace is None else namespace
        return name if name.startswith("/") else f"/{under.strip('/')}/{name}".replace("//", "/")

    def own_or_shared(self, name: str, namespace: str) -> list[str]:
        """The absolute names of a robot's own topic, and of the one that all robots share if it has none of its own."""
        return list(dict.fromkeys((self.resolve(name, namespace), self.resolve(name, "/"))))


def _named(namespace: str, patterns: tuple[str, ...]) -> bool:
    """Return whether a robot is one of those that a setting names."""
    return any(fnmatchcase(namespace, f"/{pattern.strip('/')}") for pattern in patterns)
