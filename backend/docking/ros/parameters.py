"""Declares the parameters of a node."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Any, Generic, TypeVar

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from docking.core.parameter import (
    Contents,
    Meanings,
    NodeSettings,
    Parameter,
    Value,
    from_values,
    named_parameters_of,
    parameters_of,
    shown,
)
from docking.ros.given import given_to, suggest

S = TypeVar("S", bound=NodeSettings)


TRUTH = {"true", "false"}
"""A choice with these two takes booleans, too, as a command line and a YAML file take the words for such."""


def _descriptor(parameter: Parameter) -> ParameterDescriptor:
    constraints = f"in {parameter.unit}" if parameter.unit else parameter.form
    if parameter.choices:
        constraints = f"one of: {', '.join(parameter.choices)}"
    descriptor = ParameterDescriptor(
        description=parameter.text, additional_constraints=constraints, read_only=parameter.read_only
    )
    limits = {"from_value": parameter.minimum, "to_value": parameter.maximum}
    if isinstance(parameter.default, float):
        descriptor.floating_point_range = [FloatingPointRange(**limits)]
    elif set(parameter.choices) >= TRUTH:
        descriptor.dynamic_typing = True
    elif parameter.minimum is not None:
        descriptor.integer_range = [IntegerRange(**limits, step=1)]
    return descriptor


ARRAYS = {str: RosParameter.Type.STRING_ARRAY, float: RosParameter.Type.DOUBLE_ARRAY}


def _declare(node: Node, parameter: Parameter) -> None:
    name, default, descriptor = parameter.name, parameter.default, _descriptor(parameter)
    if parameter.elements is None:
        node.declare_parameter(name, str(default) if parameter.choices else default, descriptor)
        return
    # An empty array has no type in rclpy, and one that is not set fails all requests for parameters.
    kind = ARRAYS[parameter.elements]
    if node.declare_parameter(name, list(default) or kind, ParameterDescriptor()).type_ is not kind:  # type: ignore[arg-type] # a tuple
        node.set_parameters([RosParameter(name, kind, [])])
    descriptor.type = kind.value
    node.set_descriptor(name, descriptor)


def _values(changes: Iterable[RosParameter], parameters: Mapping[str, Parameter]) -> dict[str, object]:
    """The values of the parameters that are known, by name."""
    return {
        change.name: _value(change.value, parameters[change.name]) for change in changes if change.name in parameters
    }


def _value(value: Any, parameter: Parameter) -> object:
    """An array as a tuple, empty if it is not set; `true` and `false` as the choices that they are in YAML."""
    if parameter.elements is not None:
        return tuple(value or ())
    return str(value).lower() if isinstance(value, bool) and parameter.choices else value


def _given_to(node: Node, alias: str) -> tuple[frozenset[str], dict[str, Value]]:
    """The names of what rclpy gives to a node, and all values; those for a node of another name count less."""
    overrides = node._parameter_overrides  # noqa: SLF001 - rclpy tells them only of parameters that are declared
    own = {name: _tuple(parameter.value) for name, parameter in overrides.items()}
    if not alias:
        return frozenset(own), own
    given = given_to(node.context)
    full = f"{node.get_namespace().rstrip('/')}/{alias}"
    given.aliases[node.get_fully_qualified_name()] = full
    return frozenset(own), given.of_alias(full) | own


def _tuple(value: Any) -> Any:
    return value if isinstance(value, (str, bool, int, float)) or value is None else tuple(value)


@dataclass
class _Defaults:
    """Values that count where a parameter is not given under its name: those of files, and of other programs' names."""

    values: dict[str, tuple[Value, str]] = field(default_factory=dict)

    def copy(self) -> "_Defaults":
        """Return a copy that may be changed."""
        return _Defaults(dict(self.values))

    def read(self, path: str, contents: Contents) -> list[str]:
        """Add what a file says; it counts least.

        Returns:
            Notes on ignored parts, as sentences.
        """
        self.values = {name: (value, f"{path}: {name}") for name, value in contents.values.items()} | self.values
        return [f"{path}: {name} has no effect{suggest(name, contents.known)}" for name in contents.unknown]

    def apply(self, parameter: Parameter) -> Parameter:
        """The parameter with the default that is given.

        Raises:
            ValueError: That is of the wrong type, out of range or not allowed.
        """
        if parameter.name not in self.values:
            return parameter
        value, written = self.values[parameter.name]
        if isinstance(value, bool) and set(parameter.choices) >= TRUTH:
            value = str(value).lower()
        fault = parameter.find_misfit(value) or parameter.find_fault(value)
        if fault is not None:
            raise ValueError(fault if fault.startswith(parameter.name) else f"{written} is {shown(value)}, but {fault}")
        return replace(parameter, default=value)


def _read_given(node: Node, kind: type[NodeSettings], alias: str) -> tuple[Meanings, _Defaults]:
    own, given = _given_to(node, alias)
    meanings = kind.read_given(given, node.resolve_topic_name)
    return meanings, _Defaults({name: (given[name], name) for name in given.keys() - own} | meanings.values)


class DeclaredParameters(Generic[S]):
    """The parameters of a node. All calls must come from the thread that spins it."""

    def __init__(self, node: Node, kind: type[S], on_change: Callable[[S], None], alias: str) -> None:
        """Declare them; see `declare_parameters`."""
        self._node = node
        self._kind = kind
        self._on_change = on_change
        self._values: dict[str, object] = {}
        self._parameters: dict[str, Parameter] = {}
        self._complete = False
        meanings, self._defaults = _read_given(node, kind, alias)
        defaults = self._defaults.copy()
        node.add_on_set_parameters_callback(self._refuse_faults)
        node.add_post_set_parameters_callback(self._take_over)
        for parameter in chain(parameters_of(kind), named_parameters_of(kind, self._values)):
            self._declare(defaults.apply(parameter))
            if parameter.opens is not None and (path := str(self._values[parameter.name])):
                meanings.remarks += defaults.read(path, parameter.opens(path))
        self._complete = True
        if fault := self._find_fault({}):
            raise ValueError(fault)
        _keep_notes(node, meanings)
        on_change(self._settings)

    @property
    def _settings(self) -> S:
        return from_values(self._kind, self._values)

    def reload(self, path: str = "") -> tuple[str, ...]:
        """Read the file with the defaults of named groups again, such as that of the docks; or another one.

        Parameters that are given to the node count more than the file, as at the start. What cannot be is refused as a
        whole.

        Args:
            path: The file; empty for the one that was read last.

        Returns:
            The names of the groups.

        Raises:
            ValueError: There is no file, or it has what cannot be, as a sentence.
        """
        file = next(parameter for parameter in parameters_of(self._kind) if parameter.opens is not None)
        path = path or str(self._values[file.name])
        if not path or file.opens is None:
            raise ValueError(f"{file.name} is empty: there is no file to read")
        contents = file.opens(path)
        names = contents.groups
        defaults = self._defaults.copy()
        remarks = defaults.read(path, contents)
        old = [parameter.name for parameter in named_parameters_of(self._kind, self._values, names)]
        values = {name: value for name, value in self._values.items() if name not in old} | {file.name: path}
        head = (parameter for parameter in parameters_of(self._kind) if parameter.name == names)
        new = []
        for parameter in chain(head, named_parameters_of(self._kind, values, names)):
            new.append(defaults.apply(parameter))
            values[parameter.name] = self._given(new[-1])
        if fault := from_values(self._kind, values).find_conflict():
            raise ValueError(fault)
        self._replace([*old, names], new, file.name, path)
        for remark in remarks:
            self._node.get_logger().warning(remark)
        return tuple(str(name) for name in values[names])  # type: ignore[attr-defined] # an array

    def _given(self, parameter: Parameter) -> object:
        """The value that a parameter will have: the one that is given to the node, or its default.

        Raises:
            ValueError: It is of the wrong type or not allowed.
        """
        value = _tuple(self._node._parameter_overrides[parameter.name].value) if self._is_given(parameter) else None  # noqa: SLF001 - see `_given_to`
        if value is None:
            return parameter.default
        fault = parameter.find_misfit(value) or parameter.find_fault(value)
        if fault is not None:
            raise ValueError(f"{parameter.name} is {shown(value)}, but {fault}")
        return value

    def _is_given(self, parameter: Parameter) -> bool:
        return parameter.name in self._node._parameter_overrides  # noqa: SLF001

    def _replace(self, old: Iterable[str], new: Iterable[Parameter], file: str, path: str) -> None:
        """Undeclare some parameters and declare others, which have all been checked."""
        self._complete = False
        for name in old:
            self._node.describe_parameter(name).read_only = False
            self._node.undeclare_parameter(name)
            del self._values[name], self._parameters[name]
        for parameter in new:
            self._declare(parameter)
        descriptor = self._node.describe_parameter(file)
        descriptor.read_only = False
        self._node.set_parameters([RosParameter(file, value=path)])
        descriptor.read_only = True
        self._complete = True
        self._on_change(self._settings)

    def _declare(self, parameter: Parameter) -> None:
        self._parameters[parameter.name] = parameter
        _declare(self._node, parameter)

    def _find_fault(self, changed: dict[str, object]) -> str | None:
        for name, value in changed.items():
            if fault := self._parameters[name].find_fault(value):
                return fault
        return from_values(self._kind, {**self._values, **changed}).find_conflict() if self._complete else None

    def _refuse_faults(self, changes: list[RosParameter]) -> SetParametersResult:
        fault = self._find_fault(_values(changes, self._parameters))
        return SetParametersResult(successful=fault is None, reason=fault or "")

    def _take_over(self, changes: list[RosParameter]) -> None:
        self._values.update(_values(changes, self._parameters))
        if self._complete:
            self._on_change(self._settings)


def declare_parameters(
    node: Node, kind: type[S], on_change: Callable[[S], None], alias: str = ""
) -> DeclaredParameters[S]:
    """Declare all parameters of a dataclass and keep whoever uses them up to date.

    Args:
        node: The node they belong to.
        kind: The dataclass; see `core.parameter`.
        on_change: Called with all of them, now and after each change.
        alias: Another name of the node: it also takes the parameters of a node of that name in its namespace.

    Raises:
        rclpy.exceptions.ParameterException: A value from the command line or a file is of the wrong type, out of range
            or not allowed.
        ValueError: The values cannot work together, or one cannot be honored.
    """
    return DeclaredParameters(node, kind, on_change, alias)


def _keep_notes(node: Node, meanings: Meanings) -> None:
    """Log the remarks; note which of the given parameters are honored, and why others are not."""
    for remark in meanings.remarks:
        node.get_logger().warning(remark)
    notes = given_to(node.context).notes.setdefault(node.get_fully_qualified_name(), {})
    for written, note in meanings.notes.items():
        targets = [ours for ours, (_, name) in meanings.values.items() if name == written]
        if note or not targets or any(node.has_parameter(ours) for ours in targets):
            notes[written] = note
