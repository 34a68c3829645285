"""Comments and units out of definition files."""

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Twist
from sensor_msgs.msg import BatteryState
from test_msgs.action import NestedMessage

from action_tutorials_interfaces.action import Fibonacci
from dock_gateway.ros.messages import definitions
from dock_gateway.ros.messages.definitions import Definition, definition, read_definition, unit

TEXT = """\
# A lift.
#
#  In the east wing.

# Stages
uint8 STAGE_IDLE=0
uint8 STAGE_MOVING=1   # up or down
# The door is open.
uint8 STAGE_OPEN = 2

# cut off by a blank line

uint8 stage
# Where it is.
float64 height 1.5  # above ground [m]
                    # or below it
string<=8[<=3] names ["a#b", 'c']  ## of the floors
string label "# no comment"
string SIGN=it's#open
"""


def test_comments_of_a_message_its_fields_and_its_constants() -> None:
    assert read_definition(TEXT) == Definition(
        description="A lift.\n\nIn the east wing.",
        fields={"height": "Where it is.\nabove ground [m]\nor below it", "names": "of the floors"},
        constants={"STAGE_MOVING": "up or down", "STAGE_OPEN": "The door is open.", "SIGN": "open"},
    )


@pytest.mark.parametrize("text", ["", "\n\n", "#", "uint8", "\r\n# a\r\nuint8 b\r\n", "'" * 50_000, "#" * 50_000])
def test_any_text_is_read(text: str) -> None:
    assert isinstance(read_definition(text), Definition)


def test_definitions_that_are_installed() -> None:
    assert definition(BatteryState).fields["voltage"] == "Voltage in Volts (Mandatory)"
    assert "cells known set each to NaN" in definition(BatteryState).fields["cell_voltage"]
    assert definition(Twist).description.startswith("This expresses velocity in free space")
    assert definition(DiagnosticStatus).fields["level"] == "Level of operation enumerated above."


def test_the_parts_of_an_action(monkeypatch: pytest.MonkeyPatch) -> None:
    text = "# goal definition\nint32 order # how many\n---\n# result\nint32[] sequence\n---\nint32[] partial # so far\n"
    asked = []

    def text_of(*args: str) -> str:
        asked.append(args)
        return text

    monkeypatch.setattr(definitions, "definition_text", text_of)
    read = definition.__wrapped__  # without what was read before
    assert read(Fibonacci.Goal) == Definition("goal definition", {"order": "how many"})
    assert read(Fibonacci.Result) == Definition("result")
    assert read(Fibonacci.Feedback) == Definition("", {"partial": "so far"})
    assert set(asked) == {("action_tutorials_interfaces", "action", "Fibonacci")}


def test_without_the_file_there_are_no_comments(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(definitions, "definition_text", lambda *_: None)
    assert definition.__wrapped__(BatteryState) == Definition()
    assert definition.__wrapped__(NestedMessage.Goal) == Definition()


@pytest.mark.parametrize(
    ("comment", "expected"),
    [
        ("Voltage in Volts (Mandatory)", "V"),
        ("Temperature in Degrees Celsius (If unmeasured NaN)", "°C"),
        ("Negative when discharging (A)  (If unmeasured NaN)", "A"),
        ("Capacity in Ah (design capacity)", "Ah"),
        ("speed [m/s]", "m/s"),
        ("angular speed (rad/s)", "rad/s"),
        ("acceleration in m/s^2, at most", "m/s^2"),
        ("Position covariance [m^2] defined relative", "m^2"),
        ("time between scans [seconds]", "s"),
        ("in meters", "m"),
        ("Distance (in meters) to go", "m"),
        ("The map resolution [m/cell]", "m/cell"),
        ("Charge percentage on 0 to 1 range", None),
        ("in the range [0.0-1.0]", None),
        ("may differ from the values in K.", None),
        ("in minimal form", None),
        ("in degrees of freedom", None),
        ("one of [a, b]", None),
        ("(optional) name", None),
        ("", None),
    ],
)
def test_units(comment: str, expected: str | None) -> None:
    assert unit(comment) == expected
