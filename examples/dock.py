"""Send the robot to its dock and watch it: `python examples/dock.py`."""

from dock_gateway.client import Client

with Client() as gateway:
    goal = gateway.dock()
    for feedback in goal:
        battery = feedback["current_battery_state"]
        print(f"{battery['voltage']} V, power supply status {battery['power_supply_status']}")
    print(goal.result().status)
