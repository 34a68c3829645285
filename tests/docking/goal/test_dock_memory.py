import pytest

from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Odometry
from docking.goal.dock_memory import MOST, MOST_RECORDED, MOVED, TURNED, DockMemory, LastDocking
from docking.goal.objective import Progress
from docking.nodes.dock_server import docking_objective
from docking.parameters import Dock, DockDirection, DockSettings, Staging


def test_nothing_is_known_at_first() -> None:
    assert DockMemory().recall(Pose()) is None


def test_what_was_noted_holds_while_the_robot_stands_where_it_stood() -> None:
    for docked in (True, False):
        memory = DockMemory()
        memory.note(docked, Pose(1.0, 2.0, 3.0))
        assert memory.recall(Pose(1.05, 2.05, 3.2)) is docked
        assert memory.recall(Pose(1.11, 2.0, 3.0)) is None
        assert memory.recall(Pose(1.0, 2.0, 2.6)) is None
        assert memory.recall(None) is None
        memory.moves()  # a pose tells how far
        assert memory.recall(Pose(1.0, 2.0, 3.0)) is docked


def test_without_a_pose_it_holds_until_a_goal_moves_the_robot() -> None:
    memory = DockMemory()
    memory.note(True, None)
    assert memory.recall(None) is True
    assert memory.recall(Pose()) is True
    memory.moves()
    assert memory.recall(Pose()) is None


FRONT, BACK = Staging(), Staging(dock_direction=DockDirection.BACKWARD)


def test_the_dock_of_a_goal_is_remembered_as_soon_as_the_robot_has_left_the_other_one() -> None:
    memory = DockMemory()
    memory.heads_for(FRONT, "front", None)
    assert (memory.staging, memory.dock_type) == (FRONT, "front")
    memory.note(True, Pose(1.0))
    for robot in (None, Pose(1.0), Pose(0.95)):
        memory.heads_for(BACK, "back", robot)
        assert (memory.docked, memory.staging, memory.dock_type) == (True, FRONT, "front")
    memory.heads_for(BACK, "back", Pose(0.85))
    assert (memory.docked, memory.staging, memory.dock_type) == (None, BACK, "back")
    assert memory.recall(Pose(1.0)) is None  # odometry may have drifted


def test_a_robot_that_is_on_no_dock_remembers_that_of_the_next_goal() -> None:
    memory = DockMemory(False, Pose(1.0), FRONT, "front")
    memory.heads_for(BACK, "back", None)
    assert (memory.docked, memory.staging, memory.dock_type) == (False, BACK, "back")


def test_the_dock_of_a_robot_that_was_moved_by_hand_is_that_of_the_next_goal() -> None:
    memory = DockMemory(True, Pose(1.0), FRONT, "front")
    dock = Dock(dock_direction=DockDirection.BACKWARD)
    docking = docking_objective(DockSettings(dock=dock, dock_type="back"), memory)
    odometry = Odometry(Pose(3.0), STANDSTILL, 0.0)
    assert not docking.is_reached(Observation(0.0, None, odometry), None, Progress(False, False, None))
    assert (memory.staging, memory.dock_type) == (dock, "back")


def test_a_robot_may_have_moved_by_01_m_and_035_rad() -> None:
    memory = DockMemory()
    memory.note(True, Pose())
    for near in (Pose(MOVED), Pose(theta=TURNED)):
        assert memory.recall(near) is True
    for far in (Pose(1.01 * MOVED), Pose(theta=-1.01 * TURNED)):
        assert memory.recall(far) is None


def test_docks_that_goals_describe_do_not_fill_the_memory() -> None:
    memory = DockMemory()
    for number in range(MOST + 5):
        memory.docked_at(f"({number}, 0) in map", LastDocking(Dock(), Pose(number), 0.1))
        memory.docked_at("home", LastDocking(Dock(), Pose()))
    assert len(memory.dockings) == MOST
    assert memory.last_at("home", Dock()).place == Pose()
    assert memory.last_at(f"({MOST + 4}, 0) in map", Dock()).place == Pose(MOST + 4)
    assert memory.last_at("(0, 0) in map", Dock()) == LastDocking(Dock())


@pytest.mark.parametrize(
    "changed", [Dock(external_detection_translation_y=0.03), Dock(external_detection_rotation_yaw=0.06)]
)
def test_what_was_learned_with_other_parameters_of_the_dock_is_forgotten_but_not_the_place(changed: Dock) -> None:
    memory, learned = DockMemory(), LastDocking(Dock(), Pose(1.0), turn=0.06, camera=Pose(y=0.03))
    memory.docked_at("home", learned)
    assert memory.last_at("home", Dock()) == learned
    assert memory.last_at("home", changed) == LastDocking(changed, Pose(1.0))


def test_a_place_that_is_not_known_is_that_of_the_time_before() -> None:
    memory = DockMemory()
    memory.docked_at("home", LastDocking(Dock(), Pose(1.0), camera=Pose(y=0.03)))
    memory.docked_at("home", LastDocking(Dock()))
    assert memory.last_at("home", Dock()) == LastDocking(Dock(), Pose(1.0))


def test_what_is_remembered_is_recorded_for_a_replay_whose_clock_is_another_one() -> None:
    memory = DockMemory()
    memory.note(True, Pose(1.0, 2.0, 3.0), 7.0)
    memory.heads_for(FRONT, "lab_dock", Pose(1.0, 2.0, 3.0))
    memory.docked_at("lab", LastDocking(Dock(staging_x_offset=-0.8), Pose(1.0), 0.1, Pose(0.0, 0.03)))
    memory.hits.add(Pose(4.0), 5.0)
    read = DockMemory.from_json(memory.as_json(10.0))
    assert read.shifted(10.0) == memory
    later = read.shifted(110.0)
    assert (later.since, later.hits.places) == (107.0, [(Pose(4.0), 105.0)])


def test_only_some_docks_are_recorded() -> None:
    memory = DockMemory()
    for number in range(MOST):
        memory.docked_at(str(number), LastDocking(Dock()))
    read = DockMemory.from_json(memory.as_json(0.0))
    assert list(read.dockings) == [str(number) for number in range(MOST - MOST_RECORDED, MOST)]
