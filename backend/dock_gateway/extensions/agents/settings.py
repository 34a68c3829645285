"""The settings of agents."""

import importlib.util
from typing import ClassVar

from pydantic import Field, field_validator

from dock_gateway.settings import ExtensionSettings


class AgentSettings(ExtensionSettings):
    """The settings of agents: whether they are let in, and who allows their goals."""

    group: ClassVar[str] = "Agents"

    mcp: bool = Field(
        False,
        description="Whether agents can use the gateway at `/mcp`, by the Model Context Protocol: "
        "[agents.md](extensions/agents.md). Needs `dock-gateway[mcp]`.",
    )

    approval_by_client: bool = Field(
        False,
        description="Whether the person who uses an agent may allow its goals in the agent's own program, too "
        "([agents.md](extensions/agents.md#who-allows-a-goal)). Without `authentication` that is always so.",
    )

    @field_validator("mcp")
    @classmethod
    def _check_mcp(cls, mcp: bool) -> bool:
        if mcp and importlib.util.find_spec("mcp") is None:
            raise ValueError("dock-gateway[mcp] is not installed")
        return mcp
