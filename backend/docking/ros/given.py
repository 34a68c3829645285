"""The parameters on the command line of a program, and what becomes of those that no node has."""

import difflib
import re
import sys
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from weakref import WeakKeyDictionary

import yaml
from rclpy.context import Context
from rclpy.node import Node

from docking.core.parameter import Value
from docking.core.ros_yaml import entries, parse, read_nodes, read_value

PARAMETERS = "ros__parameters"
FILE, RULE = "--params-file", ("-p", "--param")
EVERYWHERE, NOWHERE = "/**", ""
QOS = "qos_overrides."
"""What begins so is declared when the topic is used."""
QOS_FORM = re.compile(r"qos_overrides\.(/\w+)+\.(publisher|subscription)(_\w+)?\.(depth|history|reliability)")
PROGRAMS = frozenset(
    {
        "connect_to_charging_dock_action_server",
        "disconnect_from_charging_dock_action_server",
        "battery_state_subscriber",
        "connect_to_charging_dock_action_client",
        "disconnect_from_charging_dock_action_client",
        "dock_simulator",
        "fibonacci_action_server",
        "fibonacci_action_client",
    }
)
"""The nodes of our programs; several may share a file."""


@dataclass(frozen=True)
class Section:
    """Parameters for some nodes.

    Attributes:
        source: The file; empty for the command line.
        nodes: The full name of the nodes, where `*` stands for one part of it and `**` for several.
        values: The values, by name; None for one that no parameter can have.
    """

    source: str
    nodes: str
    values: Mapping[str, Value | None]

    def is_for(self, name: str) -> bool:
        """Whether it is for a node, by its full name; as in rclpy."""
        try:
            return re.fullmatch(self.nodes.replace("/*", r"(/\w+)"), name) is not None
        except re.error:
            return False


@dataclass
class Given:
    """The parameters that are given to the nodes of one context.

    Attributes:
        sections: In their order: later ones count more.
        aliases: Another full name of a node, by its full name.
        notes: What became of parameters, by the full name of the node: a sentence, empty if it is honored.
    """

    sections: Sequence[Section] = ()
    aliases: dict[str, str] = field(default_factory=dict)
    notes: dict[str, dict[str, str]] = field(default_factory=dict)

    def of_alias(self, alias: str) -> dict[str, Value]:
        """All that is given to a node of this full name."""
        found = [section.values for section in self.sections if section.is_for(alias)]
        return {name: value for values in found for name, value in values.items() if value is not None}

    def warn(self, nodes: Sequence[Node]) -> None:
        """Say once for each parameter that it has no effect, and for each file which of its nodes are not there."""
        if not nodes:
            return
        reported: set[str] = set()
        for section in self.sections:
            for name in section.values:
                if name in reported:
                    continue
                if sentence := self._judge(section, name, nodes):
                    reported.add(name)
                    nodes[0].get_logger().warning(sentence)
        for source in [section.source for section in self.sections if section.nodes == NOWHERE]:
            nodes[0].get_logger().warning(
                f"{source}: parameters in it without effect are not listed; parameters of other nodes than"
                f" {', '.join(node.get_fully_qualified_name() for node in nodes)} have no effect. It is not a file"
            )
        for source in dict.fromkeys(section.source for section in self.sections if section.nodes != NOWHERE):
            if strangers := self._strangers([one for one in self.sections if one.source == source], nodes):
                nodes[0].get_logger().warning(self._describe(source, strangers, nodes))

    def _addressed(self, section: Section, nodes: Iterable[Node]) -> list[str]:
        names = [node.get_fully_qualified_name() for node in nodes]
        return [name for name in names if section.is_for(name) or section.is_for(self.aliases.get(name, ""))]

    def _strangers(self, sections: Sequence[Section], nodes: Sequence[Node]) -> list[str]:
        """For whom the sections of one source are that are for no node of this program, nor of another one of ours."""
        heard = {_base(section.nodes) for section in sections if self._addressed(section, nodes)}
        others = PROGRAMS - {getattr(node, "own_name", node.get_name()) for node in nodes} if heard else set()
        return [
            section.nodes
            for section in sections
            if not self._addressed(section, nodes) and _base(section.nodes) not in heard | others
        ]

    def _describe(self, source: str, strangers: Sequence[str], nodes: Sequence[Node]) -> str:
        there = [node.get_fully_qualified_name() for node in nodes]
        known = [_base(name) for name in (*there, *self.aliases.values())]
        hint = next(filter(None, (suggest(_base(one), known) for one in strangers)), "")
        names = ", ".join(dict.fromkeys(strangers))
        return (
            f"{source or 'The command line'}: parameters of {names} have no effect. The nodes of this program are"
            f" {', '.join(there)}{hint}"
        )

    def _judge(self, section: Section, name: str, nodes: Sequence[Node]) -> str:
        """Return why a parameter has no effect, as a sentence; empty if it has one."""
        addressed = self._addressed(section, nodes)
        by_name = {node.get_fully_qualified_name(): node for node in nodes}
        notes = [self.notes.get(one, {}).get(name) for one in addressed]
        where = f"{section.source}: " if section.source else ""
        if note := next(filter(None, notes), ""):
            return f"{where}{note}"
        if not addressed or "" in notes or any(by_name[one].has_parameter(name) for one in addressed):
            return ""
        if name.startswith(QOS):
            form = f"{QOS}/name/of/topic.publisher.depth, with subscription, history and reliability"
            return "" if QOS_FORM.fullmatch(name) else f"{where}{name} has no effect: the form is {form}"
        known = [one for node in addressed for one in by_name[node].get_parameters_by_prefix("")]
        hint = suggest(name, known)
        return f"{where}{name} has no effect: {' and '.join(addressed)} {_have(addressed)} no such parameter{hint}"


def suggest(name: str, known: Collection[str]) -> str:
    """`. Did you mean …?` if one of the known names is similar; else empty."""
    head, dot, tail = name.rpartition(".")
    siblings = {one[len(head + dot) :]: one for one in known if one.startswith(head + dot)} if dot else {}
    names = siblings or {one: one for one in known}
    similar = difflib.get_close_matches(tail if siblings else name, names, n=1, cutoff=0.7 if siblings else 0.8)
    return f". Did you mean {names[similar[0]]}?" if similar else ""


def _have(names: Sequence[str]) -> str:
    return "has" if len(names) == 1 else "have"


def _base(name: str) -> str:
    """The name of a node without its namespace."""
    return name.rpartition("/")[2]


_given: "WeakKeyDictionary[Context, Given]" = WeakKeyDictionary()


def given_to(context: Context) -> Given:
    """Return the parameters that are given to the nodes of a context."""
    return _given.setdefault(context, Given())


def read_arguments(context: Context, args: Sequence[str] | None) -> None:
    """Note what a command line gives to the nodes of a context.

    Args:
        context: The context, whose initialization has found nothing wrong with it.
        args: None is the command line of the process.

    Raises:
        ValueError: A file has a key twice, or is too large.
    """
    _given[context] = Given([*_read(sys.argv if args is None else args)])


def _read(args: Sequence[str]) -> Iterator[Section]:
    ours = False
    for argument, following in pairwise([*args, ""]):
        if argument in {"--ros-args", "--"}:
            ours = argument == "--ros-args"
        elif ours and argument == FILE:
            yield from _read_file(following)
        elif ours and argument in RULE:
            yield from _read_rule(following)


def _read_rule(rule: str) -> Iterator[Section]:
    name, _, text = rule.partition(":=")
    node, _, parameter = name.rpartition(":")
    try:
        content = parse(text)
    except ValueError:
        content = None
    yield Section("", f"/{node.lstrip('/')}" if node else EVERYWHERE, {parameter: content and read_value(content)})


def _read_file(path: str) -> Iterator[Section]:
    if not Path(path).is_file():  # a pipe, which rcl has emptied
        yield Section(path, NOWHERE, {})
        return
    try:
        yield from _sections(path, read_nodes(Path(path)), "")
    except (OSError, ValueError) as error:
        raise ValueError(f"{FILE}: {path} {error}") from None


def _sections(source: str, node: yaml.Node | None, name: str) -> Iterator[Section]:
    for key, value in entries(node).items() if isinstance(node, yaml.MappingNode) else ():
        if key == PARAMETERS:
            yield Section(source, name, dict(_values(value, "")))
        else:
            yield from _sections(source, value, f"{name}/{key.strip('/')}")


def _values(node: yaml.Node, prefix: str) -> Iterator[tuple[str, Value | None]]:
    for key, value in entries(node).items() if isinstance(node, yaml.MappingNode) else ():
        if isinstance(value, yaml.MappingNode):
            yield from _values(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", read_value(value)
