"""Declares the parameters of a node."""

from collections.abc import Callable
from typing import TypeVar

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from docking.core.parameter import NodeSettings, Parameter, from_values, parameters_of

S = TypeVar("S", bound=NodeSettings)


TRUTH = {"true", "false"}
"""A choice with these two takes booleans, too, as a command line and a YAML file take the words for such."""


def _descriptor(parameter: Parameter) -> ParameterDescriptor:
    constraints = f"in {parameter.unit}" if parameter.unit else parameter.form
    if parameter.choices:
        constraints = f"one of: {', '.join(parameter.choices)}"
    descriptor = ParameterDescriptor(description=parameter.text, additional_constraints=constraints)
    limits = {"from_value": parameter.minimum, "to_value": parameter.maximum}
    if isinstance(parameter.default, float):
        descriptor.floating_point_range = [FloatingPointRange(**limits)]
    elif set(parameter.choices) >= TRUTH:
        descriptor.dynamic_typing = True
    elif parameter.minimum is not None:
        descriptor.integer_range = [IntegerRange(**limits, step=1)]
    return descriptor


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
    parameters = {parameter.name: parameter for parameter in parameters_of(kind)}
    declared = False

    def known(changes: list[RosParameter]) -> dict[str, object]:
        found = {change.name: change.value for change in changes if change.name in parameters}
        truths = {name for name, value in found.items() if isinstance(value, bool) and parameters[name].choices}
        return found | {name: str(found[name]).lower() for name in truths}

    def find_fault(changed: dict[str, object]) -> str | None:
        for name, value in changed.items():
            if fault := parameters[name].find_fault(value):
                return fault
        return from_values(kind, {**values, **changed}).find_conflict() if declared else None

    def refuse_faults(changes: list[RosParameter]) -> SetParametersResult:
        fault = find_fault(known(changes))
        return SetParametersResult(successful=fault is None, reason=fault or "")

    def take_over(changes: list[RosParameter]) -> None:
        values.update(known(changes))
        if declared:
            on_change(from_values(kind, values))

    node.add_on_set_parameters_callback(refuse_faults)
    node.add_post_set_parameters_callback(take_over)
    for parameter in parameters.values():
        default = str(parameter.default) if parameter.choices else parameter.default
        node.declare_parameter(parameter.name, default, _descriptor(parameter))
    declared = True
    if fault := find_fault({}):
        raise ValueError(fault)
    on_change(from_values(kind, values))
