"""Event streams: WebSocket and Server-Sent Events."""
