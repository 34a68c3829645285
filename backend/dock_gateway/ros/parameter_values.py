"""The values of ROS parameters to and from JSON, and what a node says that they may be.

As in messages, an integer beyond ±(2^53 - 1) is a decimal string, and NaN and ±Infinity are null.
"""

import difflib
import math
from array import array
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Self

from rcl_interfaces.msg import ParameterDescriptor, ParameterType, ParameterValue

from dock_gateway.core.errors import FieldError, InvalidField, got
from dock_gateway.ros.messages.codec import codec

# The types by their numbers, as `ros2 param describe` names them.
TYPES = (
    "not set",
    "boolean",
    "integer",
    "double",
    "string",
    "byte array",
    "boolean array",
    "integer array",
    "double array",
    "string array",
)
# The field of a value for each type; none for `not set`.
FIELDS = (
    None,
    "bool_value",
    "integer_value",
    "double_value",
    "string_value",
    "byte_array_value",
    "bool_array_value",
    "integer_array_value",
    "double_array_value",
    "string_array_value",
)
# The types of plain values, and those of arrays of them.
PLAIN = {bool: 1, int: 2, float: 3, str: 4}
ARRAYS = {1: 6, 2: 7, 3: 8, 4: 9}
# Rounding of a double that is given as a decimal, relative to the step.
ROUNDING = 1e-6


@dataclass(frozen=True)
class Parameter:
    """A parameter of a node: its value, and what the node says about it."""

    name: str
    value: ParameterValue
    descriptor: ParameterDescriptor

    @classmethod
    def of(cls, name: str, value: ParameterValue | None, descriptor: ParameterDescriptor | None) -> Self:
        """Return a parameter, also without a value or a descriptor of the node."""
        return cls(name, value or ParameterValue(), descriptor or ParameterDescriptor(name=name))

    @property
    def kind(self) -> int:
        """The number of its type: that of its value, or the one that it was declared with."""
        return int(self.value.type or self.descriptor.type)

    def document(self) -> dict[str, Any]:
        """Return the document that the API shows."""
        said = self.descriptor
        return {
            "name": self.name,
            "type": _type_name(self.kind),
            "value": value_document(self.value),
            "description": said.description,
            "constraints": said.additional_constraints,
            "read_only": said.read_only,
            "dynamic_typing": said.dynamic_typing,
            "range": self._range(),
        }

    def _range(self) -> dict[str, Any] | None:
        found = self._limits()
        if found is None:
            return None
        kind: Any = type(found)
        wide = codec(kind).document(found)  # an integer may be too large for a number
        return {"minimum": wide["from_value"], "maximum": wide["to_value"], "step": wide["step"]}

    def _limits(self) -> Any:
        kind, said = self.kind, self.descriptor
        if kind in (ParameterType.PARAMETER_INTEGER, ParameterType.PARAMETER_INTEGER_ARRAY):
            return next(iter(said.integer_range), None)
        if kind in (ParameterType.PARAMETER_DOUBLE, ParameterType.PARAMETER_DOUBLE_ARRAY):
            return next(iter(said.floating_point_range), None)
        return None

    def parse(self, value: object) -> ParameterValue:
        """Return a new value from decoded JSON.

        Raises:
            InvalidField: It is read-only, or the value is not of its type or out of its range.
        """
        if self.descriptor.read_only:
            raise InvalidField([FieldError(self.name, "a parameter that can be changed", "it is read-only")])
        kind = self.kind
        try:
            parsed = _parse(self.name, kind or _infer(value), value)
        except InvalidField:
            inferred = _infer(value) if self.descriptor.dynamic_typing else 0
            if inferred in (0, kind):
                raise
            return _parse(self.name, inferred, value)
        self._check_range(parsed)
        return parsed

    def _check_range(self, value: ParameterValue) -> None:
        limits = self._limits()
        if limits is None:
            return
        given = getattr(value, str(FIELDS[value.type]))
        for number in [given] if isinstance(given, int | float) else given:
            if not _is_within(number, limits.from_value, limits.to_value, limits.step):
                step = f" in steps of {limits.step:g}" if limits.step else ""
                expected = f"{limits.from_value:.12g} to {limits.to_value:.12g}{step}"
                raise InvalidField([FieldError(self.name, expected, got(number))])


def _is_within(number: float, low: float, high: float, step: float) -> bool:
    """Return whether a number is in a range. As in ROS, the end of the range counts, whatever the step."""
    if not low <= number <= high:  # not NaN, either
        return False
    if not step or number == high:
        return True
    if isinstance(number, int):
        return (number - low) % step == 0
    steps = (number - low) / step
    return math.isclose(steps, round(steps), rel_tol=ROUNDING, abs_tol=ROUNDING)


def _type_name(kind: int) -> str:
    return TYPES[kind] if kind < len(TYPES) else "unknown"


def value_document(value: ParameterValue) -> Any:
    """Return a value, ready for `orjson`; None if it is not set or of an unknown type."""
    field = FIELDS[value.type] if value.type < len(FIELDS) else None
    return None if field is None else codec(ParameterValue).document(value)[field]


def plain_value(value: ParameterValue) -> tuple[str, Any]:
    """Return the type of a value and the value itself, as Python has it; an array of bytes as `bytes`."""
    field = FIELDS[value.type] if value.type < len(FIELDS) else None
    plain: Any = None if field is None else getattr(value, field)
    if value.type == ParameterType.PARAMETER_BYTE_ARRAY:
        plain = b"".join(plain)
    elif isinstance(plain, array):
        plain = plain.tolist()
    return _type_name(value.type), plain


def _infer(value: object) -> int:
    """Return the type of a value for which the node names none; 0 if there is none."""
    if not isinstance(value, list):
        return PLAIN.get(type(value), 0)
    kinds = {PLAIN.get(type(item), 0) for item in value}
    if kinds == {PLAIN[int], PLAIN[float]}:
        kinds = {PLAIN[float]}
    kind = kinds.pop() if len(kinds) == 1 else 0
    return ARRAYS.get(kind, 0)


def _parse(name: str, kind: int, value: object) -> ParameterValue:
    field = FIELDS[kind] if kind < len(FIELDS) else None
    if field is None:
        raise InvalidField([FieldError(name, "a boolean, a number, a string or an array of one of them", got(value))])
    try:
        return codec(ParameterValue).parse({"type": kind, field: value})
    except InvalidField as error:
        raise InvalidField(
            [replace(each, path=f"{name}{each.path.removeprefix(field)}") for each in error.errors]
        ) from None


def unknown(name: str, known: Mapping[str, Parameter]) -> FieldError:
    """Return the error that a node has no parameter of a name."""
    similar = difflib.get_close_matches(name, known, n=3, cutoff=0.6)
    such_as = f", such as {', '.join(similar)}" if similar else ""
    return FieldError(name[:200], f"a parameter of the node{such_as}", "got an unknown one")
