"""The systemd unit in which a gateway runs."""

import os
import pwd
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path

# Files below these belong to people; the unit hides them unless the gateway is installed there.
HOMES = (Path("/home"), Path("/root"), Path("/run/user"))

UNIT = """\
# Written by `dock-gateway service install`, which overwrites it: change it with `systemctl{manager} edit dock-gateway`.
# Settings: {settings}
[Unit]
Description=dock-gateway: ROS 2 actions for browsers, curl and WebSockets
{after}StartLimitIntervalSec=0

[Service]
ExecStart={program} serve
ExecReload=/bin/kill -HUP $MAINPID
{environment}EnvironmentFile=-%E/dock-gateway/settings.env
Restart=on-failure
RestartSec=5
# 2: a setting is wrong, which another start does not mend.
RestartPreventExitStatus=2
# Streams and goals are handed over within 3 s. A database that does not answer takes longer.
KillMode=mixed
TimeoutStopSec=10
LimitNOFILE=65536

{sandbox}
[Install]
WantedBy={target}
"""

# Works without privileges, so for a user's own service, too. Fast DDS lists the network interfaces by netlink, and sets
# its threads to the usual scheduler.
SANDBOX = """\
UMask=0077
NoNewPrivileges=yes
LockPersonality=yes
MemoryDenyWriteExecute=yes
RestrictAddressFamilies=AF_UNIX AF_INET AF_INET6 AF_NETLINK
RestrictNamespaces=yes
RestrictRealtime=yes
RestrictSUIDSGID=yes
SystemCallArchitectures=native
SystemCallErrorNumber=EPERM
SystemCallFilter=@system-service
SystemCallFilter=~@privileged @resources
SystemCallFilter=sched_setscheduler
"""

# /dev/shm stays, which Fast DDS uses. All else that is written is in the two directories or in a /tmp of its own.
SYSTEM_SANDBOX = """\
{user}CacheDirectory=dock-gateway
CacheDirectoryMode=0700
StateDirectory=dock-gateway
StateDirectoryMode=0700
AmbientCapabilities=
CapabilityBoundingSet=
PrivateDevices=yes
PrivateTmp=yes
ProtectClock=yes
ProtectControlGroups=yes
ProtectHome={home}
ProtectHostname=yes
ProtectKernelLogs=yes
ProtectKernelModules=yes
ProtectKernelTunables=yes
ProtectProc=invisible
ProtectSystem=strict
RemoveIPC=yes
"""

# The variables by which a service of its own user finds a place for its files, and programs of other users: their
# shared memory is closed to it, so that messages have to take UDP.
SYSTEM_ENVIRONMENT = {
    "DOCK_GATEWAY_DATABASE_URL": "sqlite:///%S/dock-gateway/history.db",
    "DOCK_GATEWAY_SPOOL_PATH": "%S/dock-gateway/spool",
    "DOCK_GATEWAY_STOP_PATH": "%S/dock-gateway/stops.json",
    "XDG_CACHE_HOME": "%C",
    "ROS_LOG_DIR": "/tmp/ros-log",  # noqa: S108 - the /tmp of the service
}


def system_unit(program: Path, user: str | None, variables: Mapping[str, str]) -> str:
    """Return the unit of a service of the machine.

    Args:
        program: The command `dock-gateway`.
        user: The user that it runs as; None: one that exists only while it runs.
        variables: Variables of ROS.
    """
    in_home = any(path.is_relative_to(home) for path in paths(program, variables) for home in HOMES)
    who = f"User={user}\n" if user else "DynamicUser=yes\nUser=dock-gateway\n"
    own = "".join(f"Environment={_quote(name, value)}\n" for name, value in SYSTEM_ENVIRONMENT.items())
    return UNIT.format(
        manager="",
        settings="/etc/dock-gateway/settings.env",
        after="Wants=network-online.target\nAfter=network-online.target postgresql.service\n",
        program=_word(str(program)).replace("$", "$$"),
        environment=_environment({"FASTDDS_BUILTIN_TRANSPORTS": "UDPv4?non_blocking=true", **variables}) + own,
        sandbox=SYSTEM_SANDBOX.format(user=who, home="read-only" if in_home else "yes") + SANDBOX,
        target="multi-user.target",
    )


def user_unit(program: Path, variables: Mapping[str, str]) -> str:
    """Return the unit of a service of one user, with the files of the gateways that this user starts by hand.

    Args:
        program: The command `dock-gateway`.
        variables: Variables of ROS.
    """
    return UNIT.format(
        manager=" --user",
        settings="~/.config/dock-gateway/settings.env",
        after="",
        program=_word(str(program)).replace("$", "$$"),
        environment=_environment(variables),
        sandbox=SANDBOX,
        target="default.target",
    )


def paths(program: Path, variables: Mapping[str, str]) -> list[Path]:
    """Return what the service reads: the program, its Python and packages, and a sourced ROS."""
    listed = [
        each for name in ("PYTHONPATH", "AMENT_PREFIX_PATH") for each in variables.get(name, "").split(os.pathsep)
    ]
    python = Path(sys.executable)
    return [program, python, python.resolve(), Path(__file__), *(Path(each) for each in listed if each)]


def find_unreadable(wanted: Iterable[Path], user: str | None) -> Path | None:
    """Return a folder that is closed to a user, and so hides one of the wanted files; None if there is none.

    Args:
        wanted: Absolute paths.
        user: A user that exists; None: one that owns nothing.
    """
    uid, groups = -1, set[int]()
    if user is not None:
        entry = pwd.getpwnam(user)
        uid, groups = entry.pw_uid, set(os.getgrouplist(user, entry.pw_gid))
    for folder in dict.fromkeys(parent for path in wanted for parent in reversed(path.parents) if parent.exists()):
        status = folder.stat()
        bit = 0o100 if status.st_uid == uid else 0o010 if status.st_gid in groups else 0o001
        if uid != 0 and not status.st_mode & bit:
            return folder
    return None


def _environment(variables: Mapping[str, str]) -> str:
    """Return the lines that set variables, taken as they are."""
    return "".join(f"Environment={_quote(name, value.replace('%', '%%'))}\n" for name, value in variables.items())


def _word(text: str) -> str:
    return _escape(text.replace("%", "%%"))


def _quote(name: str, value: str) -> str:
    return _escape(f"{name}={value}")


def _escape(text: str) -> str:
    """Return a text in quotation marks, as systemd reads it."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'
