"""A route of the API. What its function declares, and its signature, say what it takes, returns and refuses."""

import inspect
from collections.abc import Callable
from typing import Any, get_args, get_origin

from fastapi import Depends, params
from fastapi.dependencies.utils import get_flat_params
from fastapi.routing import APIRoute

from dock_gateway.http.bodies import BodyReader
from dock_gateway.http.openapi import body
from dock_gateway.http.operation import READS, Operation, Trait, operation_of
from dock_gateway.http.problems import problems
from dock_gateway.http.requests import Answer
from dock_gateway.http.resource import Item, WriteCondition, conditions_of, described
from dock_gateway.http.unexpected import known_conditions, known_query, no_body

ELSEWHERE = (params.Path, params.Header, params.Cookie)


class ApiRoute(APIRoute):
    """The `route_class` of a router of the API.

    - The body is that of a parameter, `Body[Model]` or `SignedBody[Model]`.
    - The model of the answer is that of the return annotation, `Answer[Model]`, or `Item[Model]` with an `ETag`.
    - What the function does not take is refused: query parameters, unless its operation takes any; and where it may
      change something, a body and conditions on a version, unless it stops something or reads its body itself.
    - The documented errors are those of its operation, with those that follow from what it is about and takes.

    Attributes:
        query_names: The names of its query parameters.

    Raises:
        Undeclared: The function is not declared as an operation.
    """

    def __init__(self, path: str, endpoint: Callable[..., Any], **options: Any) -> None:
        operation = operation_of(endpoint)
        returned = inspect.signature(endpoint).return_annotation
        if get_origin(returned) in (Answer, Item):
            (options["response_model"],) = get_args(returned)
        if get_origin(returned) is Item:
            creates = WriteCondition in inspect.get_annotations(endpoint).values()
            answers = described(options["response_model"], status=options.get("status_code") or 200, creates=creates)
            options["responses"] = answers | (options.get("responses") or {})
        super().__init__(path, endpoint, **options)
        readers = [each.call for each in self.dependant.dependencies if isinstance(each.call, BodyReader)]
        if readers:
            self.openapi_extra = (self.openapi_extra or {}) | body(readers[0].schema, required=True)
        has_body = "requestBody" in (self.openapi_extra or {})
        errors = documented_errors(operation, has_body=has_body)
        conditions = conditions_of(each.call for each in self.dependant.dependencies)
        if conditions:
            errors |= {412, 422}
        self.responses = problems(*sorted(errors)) | self.responses
        # Those of a model are plain fields.
        flat = [each for each in get_flat_params(self.dependant) if type(each.field_info) not in ELSEWHERE]
        self.query_names = [each.alias for each in flat]
        if not operation.any_query:
            self.dependencies.append(Depends(known_query(*self.query_names)))
        if (self.methods or set()) - READS and not (operation.stops or operation.reads_body):
            self.dependencies += [Depends(known_conditions(conditions)), *([] if has_body else [Depends(no_body)])]


def documented_errors(operation: Operation, *, has_body: bool) -> set[int]:
    """Return the statuses with which a request of an operation can fail; `has_body`: whether it takes a body."""
    found = {403, *operation.errors}  # a page of another origin
    if operation.role is not None:
        found |= {401, 503}  # the identity provider may not answer
    if not operation.any_query:
        found.add(422)
    if has_body and not operation.reads_body:
        found |= {400, 408, 413, 415, 422, 429}
    if Trait.NAMED in operation.scope.traits:
        found.add(404)
    if Trait.ABOUT_ROBOTS in operation.scope.traits:
        found.add(421)
    if Trait.TYPED in operation.scope.traits:
        found.add(501)
    if operation.sends_goal:
        found.add(429)
    return found
