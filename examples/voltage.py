"""Plot the voltage during the last docking, from the history: `python examples/voltage.py`."""

from dock_gateway.client import Client

with Client() as gateway:
    (last,) = gateway.request("GET", "/dock", params={"limit": 1})["goals"]
    events = gateway.request("GET", f"/goals/{last['goal_id']}/history", params={"type": "feedback"})["events"]
for event in events:
    voltage = event["feedback"]["current_battery_state"]["voltage"]
    print(event["time"], f"{voltage:5.2f} V", "#" * round(10 * voltage))
