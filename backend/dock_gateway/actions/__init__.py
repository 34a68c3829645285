"""One action and its goals: from the request to send one until its result."""
