"""Estimates the pose of the dock from noisy detections. Plain Python."""
