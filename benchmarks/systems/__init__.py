"""The systems that are measured: the gateway, the bare client and the peers."""

# Peers that cannot be measured, and why. The table says so.
LEFT_OUT = {
    "rosbridge_suite": "it is not published on PyPI, Debian or npm",
    "foxglove_bridge": "it is not published on PyPI, Debian or npm",
}
