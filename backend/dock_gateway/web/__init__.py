"""HTTP and WebSocket: each route parses a request, calls the gateway and answers."""
