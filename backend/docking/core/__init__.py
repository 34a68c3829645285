"""The words of docking: poses, observations, battery readings, stages and error codes. Plain Python."""
