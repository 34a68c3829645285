"""One action and its goals, from the request to send a goal to its result."""
