"""Functions across robots: the overview, alerts, departures and the stop."""
