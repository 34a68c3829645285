"""Declares the parameters of a node."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from itertools import chain
from typing import Any, TypeVar

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from docking.core.parameter import NodeSettings, Parameter, Value, from_values, named_parameters_of, parameters_of

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


def declare_parameters(node: Node, kind: type[S], on_change: Callable[[S], None]) -> None:
    """Declare all parameters of a dataclass and keep whoever uses them up to date.

    Args:
        node: The node they belong to.
        kind: The dataclass; see `core.parameter`.
        on_change: Called with all of them, now and after each change.

    Raises:
        rclpy.exceptions.ParameterException: A value from the command line or a file is of the wrong type, out of range
            or not allowed.
        ValueError: The values cannot work together.
    """
    values: dict[str, object] = {}
    parameters: dict[str, Parameter] = {}
    defaults: dict[str, Value] = {}  # from files
    declared = False

    def find_fault(changed: dict[str, object]) -> str | None:
        for name, value in changed.items():
            if fault := parameters[name].find_fault(value):
                return fault
        return from_values(kind, {**values, **changed}).find_conflict() if declared else None

    def refuse_faults(changes: list[RosParameter]) -> SetParametersResult:
        fault = find_fault(_values(changes, parameters))
        return SetParametersResult(successful=fault is None, reason=fault or "")

    def take_over(changes: list[RosParameter]) -> None:
        values.update(_values(changes, parameters))
        if declared:
            on_change(from_values(kind, values))

    node.add_on_set_parameters_callback(refuse_faults)
    node.add_post_set_parameters_callback(take_over)
    for parameter in chain(parameters_of(kind), named_parameters_of(kind, values)):
        parameters[parameter.name] = parameter
        _declare(node, replace(parameter, default=defaults.get(parameter.name, parameter.default)))
        if parameter.opens is not None and (path := str(values[parameter.name])):
            defaults |= parameter.opens(path)
    declared = True
    if fault := find_fault({}):
        raise ValueError(fault)
    on_change(from_values(kind, values))
