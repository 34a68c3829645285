"""The hash of a message type, by which ROS knows whether two programs mean the same by a name."""

from functools import lru_cache

import orjson

from dock_gateway.ros.messages.interfaces import install_prefixes

KEEP = 1000


@lru_cache(KEEP)
def type_hash(type_name: str) -> str:
    """Return the hash of a message type, such as `RIHS01_df66…`; empty if the installation does not have it.

    Args:
        type_name: Such as `std_msgs/msg/String`. The messages of an action are described with it.
    """
    package, kind, name = type_name.split("/")
    own = name.partition("_")[0] if kind == "action" else name
    for prefix in install_prefixes():
        try:
            described = orjson.loads(prefix.joinpath("share", package, kind, f"{own}.json").read_bytes())
            hashes = {each["type_name"]: each["hash_string"] for each in described["type_hashes"]}
        except (OSError, ValueError, KeyError, TypeError):
            continue
        return str(hashes.get(type_name, ""))
    return ""
