"""A parameter is a field of a frozen dataclass: name, default, range, unit and text in one place.

ROS descriptors and the tables in docs/ are derived from these fields.
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import Field, dataclass, field, fields, replace
from enum import StrEnum
from typing import Any, TypeVar

Number = TypeVar("Number", int, float)
Choice = TypeVar("Choice", bound=StrEnum)
T = TypeVar("T")

NAME = re.compile(r"[A-Za-z0-9_-]+")

PARAMETER, GROUP, PREFIX, NAMES, INHERITED = "parameter", "group", "prefix", "names", "inherited"
"""Keys of a field's metadata."""

Value = bool | int | float | str | tuple[str, ...] | tuple[float, ...]


def shown(value: object) -> str:
    """A value as YAML has it."""
    if isinstance(value, tuple):
        return f"[{', '.join(map(shown, value))}]"
    return str(value).lower() if isinstance(value, bool) else repr(value)


def _accept(_value: object) -> None:
    """Find nothing wrong."""


@dataclass(frozen=True)
class Parameter:
    """The declaration of a parameter: everything but its value.

    Attributes:
        name: Its ROS name.
        default: Its default; the type of the parameter is the type of its default.
        text: What it does, as sentences.
        unit: Of a number; empty where it only counts.
        minimum: The least value of a number.
        maximum: The greatest value of a number.
        form: How a string or an array is written, where it has a form.
        read: Reads a string or an array; raises ValueError with a text that follows the parameter's name.
        elements: The type of an array's elements; None where it is not an array.
        read_only: Whether it cannot be changed while the node runs.
        opens: Reads the file that a string names.
    """

    name: str
    default: Value
    text: str
    unit: str = ""
    minimum: float | None = None
    maximum: float | None = None
    form: str = ""
    read: Callable[[Any], object] = _accept
    elements: type[str] | type[float] | None = None
    read_only: bool = False
    opens: "Callable[[str], Contents] | None" = None

    @property
    def choices(self) -> tuple[str, ...]:
        """The allowed strings; empty where it is not a choice."""
        return tuple(type(self.default)) if isinstance(self.default, StrEnum) else ()

    def find_misfit(self, value: object) -> str | None:
        """Check the type and the range of a value.

        Returns:
            The fault, as a text that follows the parameter's name; None if there is none.
        """
        if self.elements is not None:
            if isinstance(value, tuple) and all(type(one) is self.elements for one in value):
                return None
            return f"must be an array of {ELEMENT_NAMES[self.elements]}"
        if self.choices:
            return None if isinstance(value, str) else f"must be one of: {', '.join(self.choices)}"
        kind = type(self.default)
        if type(value) is not kind:
            return f"must be {TYPE_NAMES[kind]}"
        if self.minimum is not None and self.maximum is not None and isinstance(value, (int, float)):
            unit = f" {self.unit}" if self.unit else ""
            if not self.minimum <= value <= self.maximum:  # NaN is not
                return f"must be from {self.minimum:.10g} to {self.maximum:.10g}{unit}"
        return None

    def find_fault(self, value: object) -> str | None:
        """Check a value of the right type and in range; return the fault as a sentence, None if there is none."""
        if self.choices and value not in self.choices:
            return f"{self.name} is {value!r}, but must be one of: {', '.join(self.choices)}"
        try:
            self.read(value)
        except ValueError as error:
            return f"{self.name} {error}"
        return None


TYPE_NAMES = {
    bool: "true or false",
    int: "an integer",
    float: "a double, with a decimal point",
    str: "a string, in quotes",
}
ELEMENT_NAMES = {str: "strings", float: "doubles, with decimal points"}


@dataclass(frozen=True)
class Contents:
    """The parameters in a file.

    Attributes:
        values: Defaults of parameters that come later, by their names.
        unknown: The names of what else it has.
        known: Names that are similar, perhaps.
        groups: The parameter with the names of the groups that the file is about.
    """

    values: Mapping[str, Value]
    unknown: tuple[str, ...] = ()
    known: tuple[str, ...] = ()
    groups: str = ""


@dataclass
class Meanings:
    """The meaning of parameters that have names of another program.

    Attributes:
        values: By the name here: the value, and the name as it is written.
        notes: By the name as it is written: what its owner should know, as a sentence; empty if it is honored.
        remarks: More sentences.
    """

    values: dict[str, tuple[Value, str]] = field(default_factory=dict)
    notes: dict[str, str] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)


class NodeSettings:
    """The base class of all parameters of a node, which is a frozen dataclass of parameters and groups of them."""

    @classmethod
    def read_given(cls, given: Mapping[str, Value], resolve: Callable[[str], str]) -> Meanings:
        """Return the meaning of given parameters that have names of another program.

        Args:
            given: The values of all parameters that are given to the node, by their names.
            resolve: The full name of a topic.

        Raises:
            ValueError: One of them cannot be honored, and must not be ignored.
        """
        return Meanings()

    def find_conflict(self) -> str | None:
        """Return why these values, each in range, cannot work together, with the arithmetic; None where they can."""
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


def string(
    default: str, form: str, text: str, read: Callable[[str], object] = _accept, *, read_only: bool = False
) -> str:
    """A field that is a parameter: a string of a form that `read` checks."""
    return _parameter(default, Parameter("", default, text, form=form, read=read, read_only=read_only))


def file(form: str, text: str, opens: Callable[[str], Contents]) -> str:
    """A field that is a parameter: the path of a file which has defaults of later parameters; empty for none."""
    return _parameter("", Parameter("", "", text, form=form, read_only=True, opens=opens))


def names(form: str, text: str) -> tuple[str, ...]:
    """A field that is a parameter: names, each only once, for `named_groups`."""
    return _parameter((), Parameter("", (), text, form=form, read=_read_names, elements=str, read_only=True))


def numbers(form: str, text: str, read: Callable[[Sequence[float]], object]) -> tuple[float, ...]:
    """A field that is a parameter: an array of doubles, empty unless it is set."""
    return _parameter((), Parameter("", (), text, form=form, read=read, elements=float, read_only=True))


def group(kind: type[T], prefix: str = "") -> T:
    """A field that is a dataclass of parameters, whose names get a prefix."""
    return field(default_factory=kind, metadata={GROUP: kind, PREFIX: prefix})


def named_groups(kind: type[T], names: str, *, inherited: bool = False) -> Mapping[str, T]:
    """A field that is a dataclass of parameters for each of some names, which come with a dot before its parameters.

    Args:
        kind: The dataclass.
        names: The ROS name of the parameter with the names.
        inherited: Whether the defaults are the values of the parameters that have these names without the prefix.
    """
    return field(default_factory=dict, metadata={GROUP: kind, NAMES: names, INHERITED: inherited})


def _read_names(value: Sequence[str]) -> None:
    for name in value:
        if not NAME.fullmatch(name):
            raise ValueError(f"has the name {name!r}, but a name consists of letters, digits, - and _")
        if list(value).count(name) > 1:
            raise ValueError(f"has the name {name!r} twice")


def _name(part: Field[Any]) -> str:
    """A name that is a word of Python has an underscore as a field."""
    return part.name.rstrip("_")


def _parameter(default: T, parameter: Parameter) -> T:
    return field(default=default, metadata={PARAMETER: parameter})


def parameters_of(kind: type[Any], prefix: str = "") -> Iterator[Parameter]:
    """All parameters of a dataclass and of its groups, in the order of the fields; without those of named groups."""
    for part in fields(kind):
        if NAMES in part.metadata:
            continue
        if GROUP in part.metadata:
            yield from parameters_of(part.metadata[GROUP], prefix + part.metadata[PREFIX])
        elif PARAMETER in part.metadata:
            yield replace(part.metadata[PARAMETER], name=prefix + _name(part))


def named_parameters_of(kind: type[Any], values: Mapping[str, Any], names: str = "") -> Iterator[Parameter]:
    """The parameters of the named groups of a dataclass.

    Args:
        kind: The dataclass.
        values: The values of its other parameters, by ROS name.
        names: The ROS name of the parameter with the names of groups; empty for all.
    """
    for part in fields(kind):
        if NAMES in part.metadata and names in {"", part.metadata[NAMES]}:
            for name in values[part.metadata[NAMES]]:
                for parameter in parameters_of(part.metadata[GROUP]):
                    default = parameter.default
                    if part.metadata[INHERITED]:
                        default = type(default)(values[parameter.name])
                    yield replace(parameter, name=f"{name}.{parameter.name}", default=default)
        elif GROUP in part.metadata:
            yield from named_parameters_of(part.metadata[GROUP], values, names)


def from_values(kind: type[T], values: Mapping[str, Any], prefix: str = "") -> T:
    """The dataclass with the values of its parameters; other fields keep their defaults.

    Args:
        kind: The dataclass.
        values: A value for each parameter, by its ROS name.
        prefix: Of the names.
    """
    arguments: dict[str, Any] = {}
    for part in fields(kind):  # type: ignore[arg-type] # a type of a dataclass cannot be written down
        if NAMES in part.metadata:
            arguments[part.name] = {
                name: from_values(part.metadata[GROUP], values, f"{name}.") for name in values[part.metadata[NAMES]]
            }
        elif GROUP in part.metadata:
            arguments[part.name] = from_values(part.metadata[GROUP], values, prefix + part.metadata[PREFIX])
        elif PARAMETER in part.metadata:
            value = values[prefix + _name(part)]
            arguments[part.name] = type(part.default)(str(value)) if isinstance(part.default, StrEnum) else value
    return kind(**arguments)
