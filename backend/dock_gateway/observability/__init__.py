"""Metrics of the gateway, for Prometheus: docs/metrics.md.

What happens often is counted by the parts as plain integers, which `gateway_collector` reads when it is scraped.
"""
