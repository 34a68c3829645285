import pytest

from docking.simulation.faults import Fault
from docking.simulation.simulation import Simulation
from docking.simulation.status import status_of


def values(simulation: Simulation) -> dict[str, str]:
    return status_of(simulation, battery_publisher="self", real_time_factor=2.5, commands=3).values()


def test_it_tells_each_fault_and_where_the_robot_is() -> None:
    assert values(Simulation()) == {
        "dead_charger": "false",
        "flickering_charge": "false",
        "dirty_contacts": "false",
        "occluded_marker": "false",
        "stuck_wheel": "false",
        "late_commands": "false",
        "lost_commands": "false",
        "no_command_timeout": "false",
        "worn_wheel": "false",
        "wrong_detections": "false",
        "future_detections": "false",
        "lagging_detections": "false",
        "frozen_camera": "false",
        "extrapolating_camera": "false",
        "repeated_odometry": "false",
        "localization_jumps": "false",
        "frozen_odometry": "false",
        "open_loop_odometry": "false",
        "obstacle": "false",
        "occupied_dock": "false",
        "hidden_beacon": "false",
        "frozen_beacon": "false",
        "frozen_scan": "false",
        "infrared_ghosts": "false",
        "silent_battery": "false",
        "percentage_0_to_100": "false",
        "contact": "false",
        "docked": "false",
        "halted": "false",
        "battery_publisher": "self",
        "real_time_factor": "2.5",
        "commands": "3",
    }


@pytest.mark.parametrize("fault", Fault)
def test_a_fault_is_told_by_its_name(fault: Fault) -> None:
    simulation = Simulation()
    simulation.set_fault(fault, True)
    told = values(simulation)
    assert [name for name, value in told.items() if value == "true"] == [fault.value]
    assert fault.value in status_of(simulation, battery_publisher="other", real_time_factor=1.0, commands=0).message
