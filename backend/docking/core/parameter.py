"""A parameter is a field of a frozen dataclass: name, default, range, unit and text in one place.

ROS descriptors and the tables in docs/docking.md are derived from these fields.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import Field, dataclass, field, fields, replace
from enum import StrEnum
from typing import Any, TypeVar

Number = TypeVar("Number", int, float)
Choice = TypeVar("Choice", bound=StrEnum)
T = TypeVar("T")

PARAMETER, GROUP, PREFIX = "parameter", "group", "prefix"  # keys of a field's metadata


@dataclass(frozen=True)
class Parameter:
    """What is known of a parameter beside its value.

    Attributes:
        name: Its ROS name.
        default: Its default; the type of the parameter is the type of its default.
        text: What it does, as sentences.
        unit: Of a number; empty where it only counts.
        minimum: The least value of a number.
        maximum: The greatest value of a number.
        form: How a string is written, where it has a form.
        read: Reads such a string; raises ValueError with a sentence's second half.
    """

    name: str
    default: bool | int | float | str
    text: str
    unit: str = ""
    minimum: float | None = None
    maximum: float | None = None
    form: str = ""
    read: Callable[[str], object] = str

    @property
    def choices(self) -> tuple[str, ...]:
        """The allowed strings; empty where it is not a choice."""
        return tuple(type(self.default)) if isinstance(self.default, StrEnum) else ()

    def find_fault(self, value: object) -> str | None:
        """What is wrong with a value of the right type and in range; None where nothing is."""
        if self.choices and value not in self.choices:
            return f"{self.name} is {value!r}, but must be one of: {', '.join(self.choices)}"
        try:
            self.read(str(value))
        except ValueError as error:
            return f"{self.name} {error}"
        return None


class NodeSettings:
    """The base class of all parameters of a node, which is a frozen dataclass of parameters and groups of them."""

    def find_conflict(self) -> str | None:
        """Why these values, each of them in range, cannot work together, with the arithmetic; None where they can."""
        return None


def number(default: Number, minimum: Number, maximum: Number, unit: str, text: str) -> Number:
    """A field that is a parameter: a double or an integer with a closed range."""
    return _parameter(default, Parameter("", default, text, unit, minimum, maximum))


def switch(default: bool, text: str) -> bool:
    """A field that is a parameter: a bool."""
    return _parameter(default, Parameter("", default, text))


def choice(default: Choice, text: str) -> Choice:
    """A field that is a parameter: one of the strings of an enum."""
    return _parameter(default, Parameter("", default, text))


def string(default: str, form: str, text: str, read: Callable[[str], object] = str) -> str:
    """A field that is a parameter: a string of a form that `read` checks."""
    return _parameter(default, Parameter("", default, text, form=form, read=read))


def group(kind: type[T], prefix: str = "") -> T:
    """A field that is a dataclass of parameters, whose names get a prefix."""
    return field(default_factory=kind, metadata={GROUP: kind, PREFIX: prefix})


def _name(part: Field[Any]) -> str:
    """A name that is a word of Python has an underscore as a field."""
    return part.name.rstrip("_")


def _parameter(default: T, parameter: Parameter) -> T:
    return field(default=default, metadata={PARAMETER: parameter})


def parameters_of(kind: type[Any], prefix: str = "") -> Iterator[Parameter]:
    """All parameters of a dataclass and of its groups, in the order of the fields."""
    for part in fields(kind):
        if GROUP in part.metadata:
            yield from parameters_of(part.metadata[GROUP], prefix + part.metadata[PREFIX])
        elif PARAMETER in part.metadata:
            yield replace(part.metadata[PARAMETER], name=prefix + _name(part))


def from_values(kind: type[T], values: Mapping[str, object], prefix: str = "") -> T:
    """The dataclass with the values of its parameters; what is no parameter keeps its default.

    Args:
        kind: The dataclass.
        values: A value for each parameter, by its ROS name.
        prefix: Of the names.
    """
    arguments: dict[str, Any] = {}
    for part in fields(kind):  # type: ignore[arg-type] # a type of a dataclass cannot be written down
        if GROUP in part.metadata:
            arguments[part.name] = from_values(part.metadata[GROUP], values, prefix + part.metadata[PREFIX])
        elif PARAMETER in part.metadata:
            value = values[prefix + _name(part)]
            arguments[part.name] = type(part.default)(str(value)) if isinstance(part.default, StrEnum) else value
    return kind(**arguments)
