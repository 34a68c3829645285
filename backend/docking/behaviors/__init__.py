"""Behaviors, one for each stage: search, staging, approach, back out. Plain Python."""
