"""What holds of a mission whatever happens: goals that end or are lost, stops, people, and gateways that are killed."""

from hypothesis import settings

from tests.extensions.missions.machine import MissionMachine

MissionMachine.TestCase.settings = settings(max_examples=150, stateful_step_count=40, deadline=None)
TestMission = MissionMachine.TestCase
