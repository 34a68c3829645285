"""The systems that are measured: the gateway, the bare client and the peers."""
