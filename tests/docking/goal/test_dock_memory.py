from docking.core.geometry import Pose
from docking.goal.dock_memory import DockMemory


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
