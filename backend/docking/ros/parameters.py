"""Declares the parameters of a table on a node."""

from collections.abc import Callable

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from docking.parameters import ChoiceParameter, FloatParameter, Parameter, TextParameter, find_fault


def _descriptor(parameter: Parameter) -> ParameterDescriptor:
    if isinstance(parameter, ChoiceParameter):
        return ParameterDescriptor(
            description=parameter.description, additional_constraints=f"one of: {', '.join(parameter.choices)}"
        )
    if isinstance(parameter, TextParameter):
        return ParameterDescriptor(description=parameter.description, additional_constraints=parameter.form)
    descriptor = ParameterDescriptor(
        description=parameter.description, additional_constraints=f"in {parameter.unit}" if parameter.unit else ""
    )
    if isinstance(parameter, FloatParameter):
        limits = FloatingPointRange(from_value=parameter.minimum, to_value=parameter.maximum)
        descriptor.floating_point_range = [limits]
    else:
        descriptor.integer_range = [IntegerRange(from_value=parameter.minimum, to_value=parameter.maximum, step=1)]
    return descriptor


def declare_parameters(
    node: Node, table: tuple[Parameter, ...], on_change: Callable[[dict[str, object]], None]
) -> None:
    """Declare the parameters and keep whoever uses them up to date.

    Args:
        node: The node they belong to.
        table: The parameters.
        on_change: Called with the values of all of them, now and after each change.

    Raises:
        rclpy.exceptions.ParameterException: A value from the command line or a file is of the wrong type, out of range
            or not allowed.
    """
    values: dict[str, object] = {}
    names = {parameter.name for parameter in table}

    def refuse_faults(changes: list[RosParameter]) -> SetParametersResult:
        changed = {change.name: change.value for change in changes if change.name in names}
        fault = find_fault(table, {**values, **changed})
        return SetParametersResult(successful=fault is None, reason=fault or "")

    def take_over(changes: list[RosParameter]) -> None:
        values.update({change.name: change.value for change in changes if change.name in names})
        if values.keys() == names:
            on_change(dict(values))

    node.add_on_set_parameters_callback(refuse_faults)
    node.add_post_set_parameters_callback(take_over)
    for parameter in table:
        node.declare_parameter(parameter.name, parameter.default, _descriptor(parameter))
