"""The parameters of a template: `"$shelf"` as a value is replaced by the argument, `"$$x"` is `"$x"`. Plain data."""

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

from dock_gateway.core.errors import FieldError, InvalidField
from dock_gateway.extensions.missions.program import StepList, compile_steps
from dock_gateway.extensions.missions.step import StepFields
from dock_gateway.http.bodies import read_model

NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,39}")
SIGN = "$"
MAX_PARAMETERS = 50


@dataclass
class Filling:
    """Steps in which arguments are put in.

    Attributes:
        values: The arguments by their names. A parameter without one stays as it is.
        places: Where which parameter stood, by the path.
        wrong: What begins with a dollar and names no parameter.
    """

    values: Mapping[str, Any]
    places: dict[str, str] = field(default_factory=dict)
    wrong: list[FieldError] = field(default_factory=list)

    def fill(self, value: Any, path: str) -> Any:
        """Return a value with the arguments in it."""
        if isinstance(value, dict):
            return {key: self.fill(item, f"{path}.{key[:200]}") for key, item in value.items()}
        if isinstance(value, list):
            return [self.fill(item, f"{path}.{index}") for index, item in enumerate(value)]
        if not isinstance(value, str) or not value.startswith(SIGN):
            return value
        name = value[1:]
        if name.startswith(SIGN):
            return name
        if not NAME.fullmatch(name):
            self.wrong.append(FieldError(path, "a parameter such as $shelf, or $$ for a dollar", f"got {value[:60]!r}"))
            return value
        self.places[path] = name
        return self.values.get(name, value)


def check_steps(steps: list[Any], defaults: Mapping[str, Any]) -> None:
    """Check the steps of a template, as far as they are right or wrong whatever the arguments.

    Args:
        steps: The steps.
        defaults: All of its parameters, with their defaults; None: there is none.

    Raises:
        InvalidField: They use a parameter that is not there or do not use one that is, or are no steps; with the path.
    """
    filling = Filling({name: value for name, value in defaults.items() if value is not None})
    filled = filling.fill(steps, "steps")
    errors = [*filling.wrong, *_misused(filling.places, defaults)]
    open_paths = [path for path, name in filling.places.items() if defaults.get(name) is None]
    if not errors:
        errors = [each for each in _errors_of(filled) if not _depends(each.path, open_paths)]
    if errors:
        raise InvalidField(errors)


def _misused(places: Mapping[str, str], defaults: Mapping[str, Any]) -> Iterator[FieldError]:
    known = ", ".join(f"${name}" for name in defaults)
    for path, name in places.items():
        if name not in defaults:
            yield FieldError(path, f"one of {known}" if known else "no parameter", f"got ${name}")
    for name in defaults:
        if name not in places.values():
            yield FieldError(f"parameters.{name}", "a parameter that a step uses", "no step uses it")


def _errors_of(steps: list[Any]) -> list[FieldError]:
    try:
        compile_steps(read_steps(steps))
    except InvalidField as error:
        return list(error.errors)
    return []


def _depends(path: str, open_paths: list[str]) -> bool:
    """Return whether an error may go away with an argument: it is at a parameter, or about a name that may be one."""
    if path.endswith(".go_to") and any(each.endswith(".name") for each in open_paths):
        return True
    return any(path == each or path.startswith(f"{each}.") for each in open_paths)


def read_steps(steps: list[Any]) -> list[StepFields]:
    """Return steps, as clients send them.

    Raises:
        InvalidField: One is none; with the path.
    """
    return read_model(StepList, {"steps": steps}).steps


def require_arguments(given: Mapping[str, Any], defaults: Mapping[str, Any]) -> dict[str, Any]:
    """Return a value for each parameter of a template.

    Args:
        given: The arguments of a request.
        defaults: All of its parameters, with their defaults; None: there is none.

    Raises:
        InvalidField: One is missing, or there is no such parameter.
    """
    known = f"one of {', '.join(defaults)}" if defaults else "no argument"
    errors = [
        FieldError(f"arguments.{name[:200]}", known, "got an unknown one") for name in given if name not in defaults
    ]
    missing = [name for name, value in defaults.items() if value is None and name not in given]
    errors += [FieldError(f"arguments.{name}", "a value", "it is missing") for name in missing]
    if errors:
        raise InvalidField(errors)
    return {**defaults, **given}


@contextmanager
def at_arguments(places: Mapping[str, str]) -> Iterator[None]:
    """Say of what is wrong with the steps of a template in which argument that is, if it is in one.

    Args:
        places: Where in the steps which argument stands.

    Raises:
        InvalidField: That of the block, with other paths.
    """
    try:
        yield
    except InvalidField as error:
        raise InvalidField([replace(each, path=_at_argument(each.path, places)) for each in error.errors]) from None


def _at_argument(path: str, places: Mapping[str, str]) -> str:
    parts = path.split(".")
    for end in range(len(parts), 0, -1):
        name = places.get(".".join(parts[:end]))
        if name is not None:
            return ".".join(("arguments", name, *parts[end:]))
    return path
