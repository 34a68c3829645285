"""Where the dock is, from noisy detections. Plain Python."""
