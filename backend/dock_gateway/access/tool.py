"""A tool of agents. Extensions add theirs; the door of agents, `/mcp`, offers all."""

from dataclasses import dataclass, field
from typing import Any

from dock_gateway.access.carry_out import Command, Fields
from dock_gateway.core.access import Principal
from dock_gateway.http.bodies import read_model
from dock_gateway.http.operation import Operation, operation_of
from dock_gateway.http.parts import Parts
from dock_gateway.http.schema import Schema


class Nothing(Schema):
    """The arguments of a tool that takes none."""


async def _unchanged(_: Parts, __: Principal, fields: Fields) -> Fields:
    return fields


@dataclass(frozen=True)
class Tool:
    """A tool.

    Attributes:
        name: What agents call it.
        title: Its name for people.
        description: What it does, for a model that has to choose.
        command: What carries it out.
        takes: Its arguments.
        returns: Its answer.
        reads: Whether it changes nothing.
        moves: Whether it may move a robot.
        repeatable: Whether a second call with the same arguments changes nothing more.
        prepare: Makes the fields of the command.
    """

    name: str
    title: str
    description: str
    command: Command
    takes: type[Schema]
    returns: type[Schema]
    reads: bool = False
    moves: bool = False
    repeatable: bool = False
    prepare: Any = _unchanged
    operation: Operation = field(init=False)

    def __post_init__(self) -> None:
        """Refuse a command that does not say what it needs."""
        object.__setattr__(self, "operation", operation_of(self.command))

    def read(self, arguments: object) -> Fields:
        """Return the arguments of a call, with defaults and without what was not given.

        Raises:
            InvalidField: They are not what the tool takes.
        """
        read = read_model(self.takes, {} if arguments is None else arguments)
        return {name: value for name, value in read.model_dump().items() if value is not None}
