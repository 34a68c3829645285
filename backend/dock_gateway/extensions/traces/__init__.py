"""Goals as OpenTelemetry traces."""
