"""Reads YAML as ROS's own programs do: a scalar is the text that stands there, until its type is asked for."""

import re
from pathlib import Path

import yaml

from docking.core.parameter import Value

LARGEST = 1_000_000
"""The largest file that is read, in bytes."""
TRUE = frozenset({"Y", "y", "yes", "Yes", "YES", "on", "On", "ON", "true", "True", "TRUE"})
FALSE = frozenset({"N", "n", "no", "No", "NO", "off", "Off", "OFF", "false", "False", "FALSE"})
INTEGER = re.compile(r"[-+]?[0-9]+")
NUMBER = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?")
SPECIAL = re.compile(r"[-+]?\.?(inf|nan)", re.IGNORECASE)
NULL, MERGE = "tag:yaml.org,2002:null", "tag:yaml.org,2002:merge"


def read_nodes(path: Path) -> yaml.Node | None:
    """The nodes of a file; None if it is empty.

    Raises:
        OSError: It cannot be read.
        ValueError: It is too large, not UTF-8 or not YAML; the caller adds the subject to the message.
    """
    if path.exists() and not path.is_file():
        raise ValueError("is no file")
    if path.stat().st_size > LARGEST:
        raise ValueError(f"has more than {LARGEST} bytes")
    try:
        return parse(path.read_text(encoding="utf-8-sig"))
    except UnicodeDecodeError as error:
        raise ValueError(f"is not UTF-8: {error}") from None


def parse(text: str) -> yaml.Node | None:
    """The nodes of a text.

    Raises:
        ValueError: It is not YAML; the caller adds the subject to the message.
    """
    try:
        return yaml.compose(text, Loader=yaml.SafeLoader)
    except yaml.YAMLError as error:
        raise ValueError(f"is not YAML: {' '.join(str(error).split())}") from None
    except RecursionError:
        raise ValueError("is not YAML that can be read: it is nested too deeply") from None


def entries(node: yaml.Node | None) -> dict[str, yaml.Node]:
    """The nodes of a mapping, by their keys as they stand there; those of a merge (`<<`) count less than its own.

    Raises:
        ValueError: It is no mapping, or has a key twice; the caller adds the subject to the message.
    """
    if not isinstance(node, yaml.MappingNode):
        raise ValueError("is no mapping")
    own: dict[str, yaml.Node] = {}
    merged: dict[str, yaml.Node] = {}
    for key, value in node.value:
        if not isinstance(key, yaml.ScalarNode):
            raise ValueError("has a key that is no text")
        if key.tag == MERGE:
            for base in value.value if isinstance(value, yaml.SequenceNode) else [value]:
                # Of a mapping that merges another one, only its own keys: the merged mapping may contain itself.
                merged = {name.value: one for name, one in getattr(base, "value", ()) if name.tag != MERGE} | merged
        elif key.value in own:
            raise ValueError(f"has the key {key.value!r} twice")
        else:
            own[key.value] = value
    return merged | own


def read_text(node: yaml.Node) -> str:
    """A scalar as it stands there; empty for null.

    Raises:
        ValueError: It is no scalar; the caller adds the subject to the message.
    """
    if not isinstance(node, yaml.ScalarNode):
        raise ValueError("must be a text")
    return "" if node.tag == NULL else str(node.value)


def read_number(text: str) -> float | None:
    """A number as YAML, C or Python write it, such as `1`, `.5`, `1e-05`, `1_000`, `.inf`; None if it is none."""
    plain = re.sub(r"(?<=[0-9])_(?=[0-9])", "", text)
    if NUMBER.fullmatch(plain):
        return float(plain)
    return float(text.replace(".", "")) if SPECIAL.fullmatch(text) else None


def read_value(node: yaml.Node) -> Value | None:
    """The value of a parameter, as ROS's parser of parameter files understands it; None for none."""
    if isinstance(node, yaml.SequenceNode):
        values = [read_value(one) if isinstance(one, yaml.ScalarNode) else None for one in node.value]
        return None if None in values else tuple(values)  # type: ignore[return-value] # all of one type, or refused
    return _read_scalar(str(node.value), quoted=node.style in {"'", '"'}) if isinstance(node, yaml.ScalarNode) else None


def _read_scalar(text: str, *, quoted: bool) -> Value | None:
    if quoted:
        return text
    if text in TRUE or text in FALSE:
        return text in TRUE
    if INTEGER.fullmatch(text):
        return int(text)
    return read_number(text) if NUMBER.fullmatch(text) or SPECIAL.fullmatch(text) else text
