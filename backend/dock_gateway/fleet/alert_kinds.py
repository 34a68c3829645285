"""The kinds of alerts: those of the gateway itself. An extension and a hub declare their own."""

from dataclasses import dataclass

from dock_gateway.fleet.findings import FindingKind


@dataclass(frozen=True)
class AlertKind:
    """A kind of alerts.

    Attributes:
        value: The kind in documents for clients.
        critical: Whether an operator must act, if the alert itself does not say.
        on_graph: Whether it is about a fault on the ROS graph.
    """

    value: str
    critical: bool = True
    on_graph: bool = False

    def __str__(self) -> str:
        """Return the kind in documents for clients."""
        return self.value


STOP_LATCHED = AlertKind("stop_latched")
GOAL_LOST = AlertKind("goal_lost")
DISCHARGING_ON_DOCK = AlertKind("discharging_on_dock")
LOW_BATTERY = AlertKind("low_battery", critical=False)
BATTERY_IMPLAUSIBLE = AlertKind("battery_implausible", critical=False)
BATTERY_STALE = AlertKind("battery_stale", critical=False)
HISTORY_LOST = AlertKind("history_lost", critical=False)
EXTENSION_FAILED = AlertKind("extension_failed", critical=False)
DUPLICATE_ACTION_SERVER = AlertKind("duplicate_action_server", on_graph=True)
# Of a site, at a hub.
SITE_UNREACHABLE = AlertKind("site_unreachable", critical=False)
SITE_REFUSED = AlertKind("site_refused", critical=False)
SPLIT_ROBOT = AlertKind("split_robot", critical=False, on_graph=True)
OF_FINDINGS = {
    kind: AlertKind(
        kind.value,
        critical=kind not in (FindingKind.ROBOT_SEEN_TWICE, FindingKind.WRONG_TOPIC_TYPE),
        on_graph=True,
    )
    for kind in FindingKind
}
CORE_KINDS = (
    STOP_LATCHED,
    GOAL_LOST,
    DISCHARGING_ON_DOCK,
    LOW_BATTERY,
    BATTERY_IMPLAUSIBLE,
    BATTERY_STALE,
    HISTORY_LOST,
    EXTENSION_FAILED,
    DUPLICATE_ACTION_SERVER,
    SPLIT_ROBOT,
    SITE_UNREACHABLE,
    SITE_REFUSED,
    *OF_FINDINGS.values(),
)
