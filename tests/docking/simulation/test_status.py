import json

import pytest

from docking.simulation.faults import Fault
from docking.simulation.room import WORKSHOP
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation
from docking.simulation.status import status_of


def values(simulation: Simulation) -> dict[str, str]:
    return status_of(simulation, battery_publisher="self", real_time_factor=2.5, too_slow=False, commands=3).values()


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
        "too_slow": "false",
        "places": "{}",
        "commands": "3",
    }


@pytest.mark.parametrize("fault", Fault)
def test_a_fault_is_told_by_its_name(fault: Fault) -> None:
    simulation = Simulation()
    simulation.set_fault(fault, True)
    told = values(simulation)
    assert [name for name, value in told.items() if value == "true"] == [fault.value]
    assert (
        fault.value
        in status_of(simulation, battery_publisher="other", real_time_factor=1.0, too_slow=False, commands=0).message
    )


def test_a_machine_that_is_too_slow_is_told() -> None:
    status = status_of(Simulation(), battery_publisher="self", real_time_factor=0.42, too_slow=True, commands=0)
    assert status.message == "the machine is too slow: the simulation runs at 0.42 of real time"
    assert status.values()["too_slow"] == "true"


def test_the_places_of_the_room_are_told() -> None:
    places = json.loads(values(Simulation(Settings(room=WORKSHOP)))["places"])
    assert places["shelf"] == [-4.0, -2.6, -1.5708]
    assert places.keys() == dict(WORKSHOP.places).keys()
