"""What an agent does with ros-mcp: agent.py <ros-mcp> <port of rosbridge>. Prints the answers of its tools as JSON."""

import asyncio
import json
import sys

from fastmcp import Client
from fastmcp.client.transports import StdioTransport

FIBONACCI = "action_tutorials_interfaces/action/Fibonacci"
TWIST = {"linear": {"x": 0.1}}
CALLS = {
    "connect_to_robot": {"ip": "127.0.0.1", "port": int(sys.argv[2])},
    "get_topics": {},
    "subscribe_once": {"topic": "/talker0/scan", "msg_type": "sensor_msgs/msg/LaserScan", "timeout": 10},
    "send_action_goal": {"action_name": "/fibonacci", "action_type": FIBONACCI, "goal": {"order": 4}, "timeout": 30},
    "publish_for_durations": {
        "topic": "/cmd_vel",
        "msg_type": "geometry_msgs/msg/Twist",
        "messages": [TWIST],
        "durations": [0.1],
    },
}


async def main() -> None:
    """Call each tool once."""
    seen = {}
    async with Client(StdioTransport(sys.argv[1], [])) as agent:
        for tool, arguments in CALLS.items():
            answer = await agent.call_tool(tool, arguments)
            seen[tool] = json.loads(answer.content[0].text)
    print(json.dumps(seen))


asyncio.run(main())
