"""Finds environment variables of ROS and DDS that keep a node from seeing what it should see."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

# rcl's largest domain, and those whose ports Linux gives to other programs.
MAX_DOMAIN, EPHEMERAL = 232, range(102, 215)
RANGES = ("SUBNET", "LOCALHOST", "OFF", "SYSTEM_DEFAULT", "NOT_SET")
PROFILES = ("FASTDDS_DEFAULT_PROFILES_FILE", "FASTRTPS_DEFAULT_PROFILES_FILE")
TRUE = ("1", "TRUE", "true")
DISCOVERY_SERVER_HINT = (
    "ROS_DISCOVERY_SERVER is set without ROS_SUPER_CLIENT=true, so this node sees only parts of the ROS graph: topics "
    "may arrive while action servers are not found. Set ROS_SUPER_CLIENT=true"
)


class Finding(NamedTuple):
    """A fault, as a sentence without a full stop, and whether it is fatal: nothing can work with it."""

    sentence: str
    fatal: bool = False


def sees_part_of_graph(environment: Mapping[str, str]) -> bool:
    """Return whether the node is a client of a discovery server that reports only the topics it subscribes to."""
    client = environment.get("ROS_SUPER_CLIENT", "") in TRUE
    return bool(environment.get("ROS_DISCOVERY_SERVER", "").strip("; ")) and not client


def check(environment: Mapping[str, str]) -> list[Finding]:
    """Return the faults of the variables of ROS and DDS."""
    return [*check_domain(environment), *check_discovery(environment)]


def check_discovery(environment: Mapping[str, str]) -> list[Finding]:
    """Return the faults of the variables by which nodes find each other."""
    return [*_range(environment), *_files(environment), *_security(environment)]


def check_domain(environment: Mapping[str, str]) -> Iterator[Finding]:
    """Yield the fault of the ROS domain, if there is one."""
    text = environment.get("ROS_DOMAIN_ID", "")
    if not text:
        return
    if not (text.isascii() and text.isdecimal()) or int(text) > MAX_DOMAIN:
        yield Finding(
            f"ROS_DOMAIN_ID is {text!r}, which is no number from 0 to {MAX_DOMAIN}: run `export ROS_DOMAIN_ID=` with "
            "that of the robots, or `unset ROS_DOMAIN_ID` for 0",
            fatal=True,
        )
    elif int(text) in EPHEMERAL:
        yield Finding(
            f"ROS_DOMAIN_ID {text} uses ports that Linux also gives to other programs, so nodes may fail to start; "
            "domains up to 101 do not"
        )


def _range(environment: Mapping[str, str]) -> Iterator[Finding]:
    found = environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "")
    if found and found not in RANGES:
        yield Finding(
            f"ROS_AUTOMATIC_DISCOVERY_RANGE is {found!r}, which is none of {', '.join(RANGES)}: ROS then finds "
            "nodes on this machine alone"
        )
    if found == "OFF":
        yield Finding("ROS_AUTOMATIC_DISCOVERY_RANGE is OFF, so no node of others is found, not even on this machine")
    if found and found != "LOCALHOST" and environment.get("ROS_LOCALHOST_ONLY") == "1":
        yield Finding(
            f"ROS_LOCALHOST_ONLY=1 overrides ROS_AUTOMATIC_DISCOVERY_RANGE={found}: nodes on other machines are not "
            "found. It is deprecated; unset it"
        )
    if sees_part_of_graph(environment):
        yield Finding(DISCOVERY_SERVER_HINT)


def _files(environment: Mapping[str, str]) -> Iterator[Finding]:
    for name in PROFILES:
        if not (path := environment.get(name, "")):
            continue
        try:
            ElementTree.parse(Path(path))  # noqa: S314 - a file that the user of this process names
        except (OSError, ElementTree.ParseError) as error:
            yield Finding(f"{name} names {path}, which cannot be read: {error}. Fast DDS then uses its defaults")


def _security(environment: Mapping[str, str]) -> Iterator[Finding]:
    if environment.get("ROS_SECURITY_ENABLE") != "true":
        return
    keystore = environment.get("ROS_SECURITY_KEYSTORE", "")
    if not keystore or not Path(keystore).is_dir():
        named = f"{keystore}, which is no folder" if keystore else "unset"
        strict = environment.get("ROS_SECURITY_STRATEGY") == "Enforce"
        yield Finding(f"ROS_SECURITY_ENABLE is true, but ROS_SECURITY_KEYSTORE is {named}", fatal=strict)
