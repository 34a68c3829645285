"""Cancels a goal by its id, whichever action it is on."""

from dock_gateway.core.goal import Goal
from dock_gateway.goals.cancellation import require_unfinished
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.registry import ActionRegistry


async def request_cancel(goals: Goals, actions: ActionRegistry, goal_id: str) -> Goal:
    """Ask the action server to cancel a goal of any action, regardless of its sender.

    Raises:
        NotAuthenticated: The login of who cancels it has ended meanwhile (`invalid_token`).
        NotFound: There is no such goal, or its action has no server.
        Conflict: The goal has ended (`goal_terminal`), or the server refuses (`cancel_rejected`).
        Unavailable: The action server is gone.
        ServerTimeout: The server did not answer in time.
    """
    goal = await goals.get(goal_id)
    require_unfinished(goal)
    action = await actions.find(goal.action_name)
    goal = await goals.get(goal_id)  # it may have returned or ended meanwhile
    await action.canceler.cancel(goal)
    return goal
