"""Decode every message of a recording with mcap-ros2-support: decode.py <file>. Prints JSON, by topic."""

import json
import math
import sys
from pathlib import Path
from typing import Any

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory


def plain(value: Any) -> Any:
    """As `decode.mjs` prints it."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, bool | int | str):
        return value
    if hasattr(value, "__slots__"):
        return {name.removeprefix("_"): plain(getattr(value, name)) for name in value.__slots__}
    return [plain(each) for each in value]


def read(file: Path) -> dict[str, list[Any]]:
    """All messages, by topic."""
    decoders = DecoderFactory()
    topics: dict[str, list[Any]] = {}
    with file.open("rb") as stream:
        for schema, channel, message in make_reader(stream, validate_crcs=True).iter_messages():
            decode = decoders.decoder_for(channel.message_encoding, schema)
            if decode is None:
                raise ValueError(f"{channel.topic} cannot be decoded")
            topics.setdefault(channel.topic, []).append(plain(decode(message.data)))
    return topics


print(json.dumps(read(Path(sys.argv[1]))))
