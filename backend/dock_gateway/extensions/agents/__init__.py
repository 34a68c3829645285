"""`/mcp`: agents use the gateway by the Model Context Protocol."""
