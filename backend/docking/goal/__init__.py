"""One goal from its acceptance to its end: admission, stages, retries, deadlines, limits of motion. Plain Python."""
