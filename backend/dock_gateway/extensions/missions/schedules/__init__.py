"""Schedules: missions that are queued by themselves, at times."""
