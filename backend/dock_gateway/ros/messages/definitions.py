"""Comments and units from ROS definition files.

As in rosidl, comments at the top of the file describe the message, comments directly above or after a field or constant
describe it, and indented lines continue them. A blank line separates a comment from what follows.
"""

import re
from dataclasses import dataclass, field
from functools import cache

from dock_gateway.ros.messages.interfaces import definition_text
from dock_gateway.ros.messages.types import MessageClass, type_name

# The parts of a definition file, in order, by its kind.
PARTS = {"action": ("Goal", "Result", "Feedback"), "srv": ("Request", "Response")}

_LINE = re.compile(r"""(?P<code>(?:[^#"']|"(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])*'|["'])*?)(?:\#+(?P<comment>.*))?""")
_ELEMENT = re.compile(r"\S+\s+(?P<name>[A-Za-z]\w*)\s*(?P<constant>=)?")

# Words for units → their symbols.
_WORDS = {
    "meter": "m",
    "metre": "m",
    "second": "s",
    "sec": "s",
    "radian": "rad",
    "degree": "°",
    "degrees celsius": "°C",
    "celsius": "°C",
    "volt": "V",
    "amp": "A",
    "ampere": "A",
    "watt": "W",
    "newton": "N",
    "newton-meter": "N·m",
    "pascal": "Pa",
    "kelvin": "K",
    "tesla": "T",
    "lux": "lx",
    "hertz": "Hz",
    "percent": "%",
    "pixel": "px",
    "kilogram": "kg",
    "millisecond": "ms",
    "nanosecond": "ns",
    "millimeter": "mm",
    "minute": "min",
    "hour": "h",
}
_SYMBOLS = [
    "m",
    "mm",
    "cm",
    "km",
    "s",
    "ms",
    "us",
    "ns",
    "min",
    "h",
    "rad",
    "deg",
    "V",
    "mV",
    "A",
    "mA",
    "Ah",
    "mAh",
    "Wh",
    "W",
    "N",
    "Nm",
    "Pa",
    "hPa",
    "K",
    "°C",
    "T",
    "Hz",
    "kHz",
    "kg",
    "g",
    "px",
    "%",
    "°",
    "lx",
    "J",
    "cell",
]
_WORD = "|".join(sorted((rf"{word}{'' if word.endswith('s') else 's?'}" for word in _WORDS), key=len, reverse=True))
_FACTOR = rf"(?:{'|'.join(sorted(map(re.escape, _SYMBOLS), key=len, reverse=True))})(?:\^?-?[23])?"
_SYMBOL = rf"{_FACTOR}(?:[/*·]{_FACTOR})*"
_ATOM = rf"(?P<{{0}}symbol>{_SYMBOL})|(?P<{{0}}word>(?i:{_WORD}))"
_UNIT = re.compile(
    rf"[\[(]\s*(?:in\s+)?(?:{_ATOM.format('a')})\s*[\])]"  # [m/s], (Volts)
    rf"|\b[iI]n\s+(?![KTJNWgh]\b(?!/))(?:{_ATOM.format('b')})(?![\w/])(?!\s+of\b)"  # in meters, not: in K = …
)


@dataclass(frozen=True)
class Definition:
    """The comments of a definition on the message, its fields and its constants."""

    description: str = ""
    fields: dict[str, str] = field(default_factory=dict)
    constants: dict[str, str] = field(default_factory=dict)


@cache
def definition(message_class: MessageClass) -> Definition:
    """Return the comments of a message class, none if its definition file is not installed."""
    package, kind, name = type_name(message_class).split("/")
    if kind in PARTS:
        name, _, part = name.rpartition("_")
        text = definition_text(package, kind, name)
        sections = re.split(r"^---.*\n?", text or "", flags=re.MULTILINE)
        if part not in PARTS[kind] or len(sections) != len(PARTS[kind]):
            return Definition()
        return read_definition(sections[PARTS[kind].index(part)])
    return read_definition(definition_text(package, kind, name) or "")


def read_definition(text: str) -> Definition:
    """Read the comments from the definition text of one message."""
    lines = text.splitlines()
    head: list[str] = []
    while lines and lines[0].startswith("#"):
        head.append(lines.pop(0).lstrip("#"))
    fields: dict[str, list[str]] = {}
    constants: dict[str, list[str]] = {}
    above: list[str] = []
    own: list[str] | None = None
    heading: list[str] | None = None  # the comment of a constant that may be the heading of a group
    for line in lines:
        match = _LINE.fullmatch(line)
        code, comment = match.group("code", "comment") if match else (line, None)
        element = _ELEMENT.match(code.strip())
        if element:
            own = [] if comment and element["constant"] else list(above)
            if element["constant"]:
                constants[element["name"]] = own
            else:
                fields[element["name"]] = own
            if heading is not None and element["constant"] and not above:
                heading.clear()
            heading = own if element["constant"] and above and not comment else None
            above = []
            if comment:
                own.append(comment)
        elif comment is None:
            above, own, heading = [], None, None
        elif code and own is not None:
            own.append(comment)
        else:
            above.append(comment)
            heading = None
    return Definition(
        _join(head),
        {name: text for name, comment in fields.items() if (text := _join(comment))},
        {name: text for name, comment in constants.items() if (text := _join(comment))},
    )


def unit(comment: str) -> str | None:
    """Return the first unit that a comment names, as in "(Volts)", "[m/s]" or "in meters"."""
    match = _UNIT.search(comment)
    if not match:
        return None
    if symbol := match["asymbol"] or match["bsymbol"]:
        return symbol
    word = (match["aword"] or match["bword"]).lower()
    return _WORDS.get(word) or _WORDS[word.removesuffix("s")]


def _join(lines: list[str]) -> str:
    return "\n".join(line.strip() for line in lines).strip()
