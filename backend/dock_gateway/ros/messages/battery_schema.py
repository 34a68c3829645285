"""The schemas of BatteryState in the OpenAPI document, which it gets from the ROS definition."""

from typing import Any

from sensor_msgs.msg import BatteryState

from dock_gateway.ros.messages.codec import codec


def battery_schemas() -> dict[str, Any]:
    """Return the schemas of BatteryState and of what is nested in it, by name: as it is sent, and as it is read."""
    schemas: dict[str, Any] = {}
    _add_message(schemas, "BatteryState", "null is NaN: not measured.", complete=True)
    _add_message(
        schemas,
        "BatteryStateInput",
        "Fields left out are NaN (floats) or the default, null is NaN; constants are also taken by name (CHARGING).",
        complete=False,
    )
    return schemas


def _add_message(schemas: dict[str, Any], name: str, note: str, *, complete: bool) -> None:
    """Add BatteryState and its nested messages, each as its own component."""
    schema = codec(BatteryState).schema(complete=complete)
    suffix = "" if complete else "Input"

    def refer(value: Any) -> Any:
        if isinstance(value, list):
            return [refer(item) for item in value]
        if not isinstance(value, dict):
            return value
        return {
            key: f"{item.replace('#/$defs/', '#/components/schemas/')}{suffix}" if key == "$ref" else refer(item)
            for key, item in _plain(value).items()
        }

    for nested, definition in schema.pop("$defs").items():
        schemas[f"{nested}{suffix}"] = refer(definition)
    schemas[name] = refer(schema) | {"title": name, "description": f"sensor_msgs/BatteryState. {note}"}


def _plain(schema: dict[str, Any]) -> dict[str, Any]:
    """Remove what type generators misread.

    They treat a field with a default as always present, and a number that may be given by name as text.
    """
    schema = {key: value for key, value in schema.items() if key != "default"}
    if "x-constants" in schema and "anyOf" in schema:
        schema |= next(option for option in schema.pop("anyOf") if option.get("type") == "integer")
    return schema
