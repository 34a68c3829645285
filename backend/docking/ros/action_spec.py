"""What an action is that drives the robot: all that docking and undocking differ in."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from docking.core.errors import Stage
from docking.core.footprint import Footprint
from docking.core.transform import Transform
from docking.goal.admission import Purpose
from docking.goal.dock_memory import DockMemory
from docking.goal.engine import Goal
from docking.parameters import DockPlace, ServerSettings, StagingGoal
from docking.ros.sensors import Sensor

S = TypeVar("S", bound=ServerSettings)


@dataclass(frozen=True)
class ActionSpec(Generic[S]):
    """One action.

    Attributes:
        node_name: The name of the node that serves it.
        action_name: The name of the action.
        action_type: Its type.
        purpose: What its goals may ask for.
        settings: The dataclass of the node's parameters.
        needs: What a goal needs to know, by the parameters.
        control_period: Seconds between two control steps, by the parameters.
        make_goal: Makes a goal that begins at a moment, by the parameters and what is remembered of the dock.
        progress: What is logged once a second at a stage.
        success: What is logged at the end.
        ends_with_charge: Whether a message of a charging battery is looked at as soon as it comes.
        outline: The robot's footprint, by the parameters; None where it is not published.
        at_dock: The parameters for a goal at a dock, by the dock's name; raises DockNotInDb.
        dock_types: Types of docks that have parameters of their own.
        marker_tilt: How the marker's axes are turned, by the parameters; see `Sensors`.
        navigates: Whether goals may begin with a navigation to a staging pose.
        staging: Where to, by the parameters for a goal; None where there is none.
        has_places: Whether the database has poses of docks that goals use.
        place: Where the database has the goal's dock, by the parameters for a goal; None where it does not.
    """

    node_name: str
    action_name: str
    action_type: type
    purpose: Purpose
    settings: type[S]
    needs: Callable[[S], frozenset[Sensor]]
    control_period: Callable[[S], float]
    make_goal: Callable[[S, DockMemory, float], Goal]
    progress: Mapping[Stage, str]
    success: Sequence[str]
    ends_with_charge: bool = False
    outline: Callable[[S], Footprint] | None = None
    at_dock: Callable[[S, str], S] = lambda settings, _: settings
    dock_types: Callable[[S], Sequence[str]] = lambda _: ()
    marker_tilt: Callable[[S], Transform] = lambda _: Transform()
    navigates: Callable[[S], bool] = lambda _: False
    staging: Callable[[S], StagingGoal | None] = lambda _: None
    place: Callable[[S], DockPlace | None] = lambda _: None
    has_places: Callable[[S], bool] = lambda _: False
