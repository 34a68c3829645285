"""A template: what clients send and get, and what is stored."""

from collections.abc import Mapping
from datetime import datetime
from typing import Annotated, Any

from pydantic import AfterValidator, ConfigDict, Field, JsonValue

from dock_gateway.core.event import utc_now
from dock_gateway.extensions.missions.battery import BatteryLimits
from dock_gateway.extensions.missions.mission import PRIORITY, Priority
from dock_gateway.extensions.missions.program import MAX_STEPS
from dock_gateway.extensions.missions.templates.parameters import MAX_PARAMETERS, NAME, check_steps
from dock_gateway.http.bodies import Name60, expected
from dock_gateway.http.resource import Versioned
from dock_gateway.http.schema import Schema

EXAMPLE: JsonValue = {
    "name": "Fetch",
    "parameters": {"shelf": {"description": "Where to load"}, "charge": {"default": 0.8}},
    "steps": [
        {"navigate": {"place": "$shelf"}},
        {"notify": {"text": "Load me"}},
        {"wait": {"person": True}},
        {"dock": {}},
        {"wait": {"battery": "$charge"}},
    ],
}


class Parameter(Schema):
    """A parameter of a template. Without a `default`, or with null, a mission has to say what it is."""

    description: Annotated[str, Field(max_length=200)] | None = None
    default: Annotated[Any, Field(description="Any value; null: there is none")] = None


def _check_names(parameters: dict[str, Parameter]) -> dict[str, Parameter]:
    for name in parameters:
        if not NAME.fullmatch(name):
            raise expected("a name of up to 40 letters, digits and _, without a digit first", path=name[:200])
    return parameters


class TemplateFields(Schema):
    """The fields of a template. `name`, `priority` and `battery` are those of its missions."""

    name: Name60 | None = None
    priority: Priority = PRIORITY
    battery: BatteryLimits | None = None
    parameters: Annotated[
        dict[str, Parameter], Field(max_length=MAX_PARAMETERS, default_factory=dict), AfterValidator(_check_names)
    ]
    steps: Annotated[
        list[Any],
        Field(
            min_length=1,
            max_length=MAX_STEPS,
            description="Steps, as those of a mission; a value `$shelf` is that of the parameter `shelf`",
        ),
    ]

    @property
    def defaults(self) -> Mapping[str, Any]:
        """All of its parameters, with their defaults; None: there is none."""
        return {name: parameter.default for name, parameter in self.parameters.items()}


class TemplateEntry(TemplateFields):
    """A template as it is stored: who changed it last, if known, and when."""

    changed_by: str | None
    changed_at: datetime


class TemplateBody(TemplateFields):
    """A template that is stored. `by` is who changes it."""

    model_config = ConfigDict(json_schema_extra={"examples": [EXAMPLE]})

    by: Name60 | None = None

    def entry(self) -> TemplateEntry:
        """Return the template, changed now.

        Raises:
            InvalidField: As `check_steps`.
        """
        check_steps(self.steps, self.defaults)
        fields = {name: getattr(self, name) for name in TemplateFields.model_fields}
        return TemplateEntry(**fields, changed_by=self.by, changed_at=utc_now())


class Template(TemplateEntry, Versioned):
    """A mission with parameters: `{"template": "fetch", "arguments": {"shelf": "a3"}}`."""

    id: str


class TemplateList(Schema):
    """The templates, by id."""

    templates: list[Template]
