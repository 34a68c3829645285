"""The path of a goal, `/goals/{goal_id}`, and its other spellings: below the paths where goals are sent."""

from collections.abc import Callable
from typing import Any, TypeVar

from fastapi import APIRouter

F = TypeVar("F", bound=Callable[..., Any])

GOAL = "/goals/{goal_id}"
# Answered in the same way, with any goal, and not documented.
SPELLINGS = ("/dock/{goal_id}", "/undock/{goal_id}", "/actions/{name:graph_name}/goals/{goal_id}")


def at_goal(router: APIRouter, method: str, ending: str = "", **options: Any) -> Callable[[F], F]:
    """Make a function a route of a goal.

    Args:
        router: The router.
        method: The method.
        ending: What follows the path of the goal.
        options: Those of the route.
    """

    def add(function: F) -> F:
        router.add_api_route(f"{GOAL}{ending}", function, methods=[method], **options)
        for path in SPELLINGS:
            router.add_api_route(f"{path}{ending}", function, methods=[method], include_in_schema=False, **options)
        return function

    return add
