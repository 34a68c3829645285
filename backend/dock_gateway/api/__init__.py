"""The web side: each module parses a request, calls the gateway and answers."""
