"""`python -m dock_gateway`."""

from dock_gateway.cli import main

main()
