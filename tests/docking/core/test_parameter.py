import enum
from dataclasses import dataclass

import pytest

from docking.core.parameter import (
    NodeSettings,
    Parameter,
    choice,
    from_values,
    group,
    number,
    parameters_of,
    string,
    switch,
)


class Colour(enum.StrEnum):
    RED = "red"
    BLUE = "blue"


def read_even(text: str) -> int:
    if len(text) % 2:
        raise ValueError("has an odd length")
    return len(text)


@dataclass(frozen=True, slots=True)
class Wheel:
    radius: float = number(0.1, 0.0, 1.0, "m", "Radius.")
    spokes: int = number(8, 0, 100, "", "Spokes.")


@dataclass(frozen=True)
class Cart(NodeSettings):
    colour: Colour = choice(Colour.RED, "Colour.")
    left: Wheel = group(Wheel, "left_")
    right: Wheel = group(Wheel, "right_")
    name: str = string("", "text", "Name.", read_even)
    brakes: bool = switch(True, "Has brakes.")
    owner: str = "nobody"


def test_the_parameters_are_the_fields_in_their_order() -> None:
    parameters = list(parameters_of(Cart))
    names = ["colour", "left_radius", "left_spokes", "right_radius", "right_spokes", "name", "brakes"]
    assert [parameter.name for parameter in parameters] == names
    assert parameters[1] == Parameter("left_radius", 0.1, "Radius.", "m", 0.0, 1.0)
    assert parameters[0].choices == ("red", "blue")


def test_values_become_the_dataclass_and_what_is_no_parameter_keeps_its_default() -> None:
    values = {parameter.name: parameter.default for parameter in parameters_of(Cart)}
    assert from_values(Cart, values) == Cart()
    cart = from_values(Cart, {**values, "colour": "blue", "right_radius": 0.2, "brakes": False})
    assert cart == Cart(Colour.BLUE, right=Wheel(0.2), brakes=False)
    assert cart.colour is Colour.BLUE


@pytest.mark.parametrize(
    ("name", "value", "fault"),
    [
        ("colour", "green", "colour is 'green', but must be one of: red, blue"),
        ("colour", "blue", None),
        ("name", "abc", "name has an odd length"),
        ("name", "ab", None),
        ("left_radius", 0.5, None),
    ],
)
def test_a_value_that_is_not_allowed_is_a_fault(name: str, value: object, fault: str | None) -> None:
    (parameter,) = [parameter for parameter in parameters_of(Cart) if parameter.name == name]
    assert parameter.find_fault(value) == fault


def test_settings_have_no_conflict_unless_they_say_so() -> None:
    assert Cart().find_conflict() is None
