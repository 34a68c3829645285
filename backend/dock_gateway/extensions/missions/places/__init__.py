"""Places: poses with a name, that missions drive to."""
