"""Figures: what was measured of which system, turn by turn, and what was left out. Plain data."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from statistics import median

BARE, OURS, STOCK = "bare rclpy", "dock-gateway", "stock FastAPI"
ROSBRIDGE, ROSBRIDGE_SUITE = "rosbridge-server-rs", "rosbridge_suite"


@dataclass
class Figure:
    """One measure of one system, with a value for each turn."""

    case: str
    measure: str
    system: str
    unit: str
    turns: list[float] = field(default_factory=list)

    @property
    def value(self) -> float:
        """The median of the turns."""
        return median(self.turns)

    @property
    def spread(self) -> tuple[float, float]:
        """The lowest and the highest turn."""
        return min(self.turns), max(self.turns)


@dataclass
class Results:
    """All figures of a run."""

    figures: dict[tuple[str, str, str], Figure] = field(default_factory=dict)
    left_out: dict[tuple[str, str], list[str]] = field(default_factory=dict)

    def add(self, case: str, measure: str, system: str, value: float, unit: str = "ms") -> None:
        """Add the value of one turn."""
        key = case, measure, system
        self.figures.setdefault(key, Figure(*key, unit)).turns.append(value)

    def latencies(self, case: str, what: str, system: str, samples: Iterable[float]) -> None:
        """Add the median and the 99th percentile of the latencies of one turn."""
        values = sorted(samples)
        for name, share in (("p50", 0.5), ("p99", 0.99)):
            if values:
                self.add(case, f"{what} {name}".strip(), system, percentile(values, share))

    def leave_out(self, system: str, case: str, why: str) -> None:
        """Record why a turn gave no figure; without a case, why the system was not measured at all."""
        self.left_out.setdefault((system, case), []).append(why)

    def rows(self) -> list[tuple[str, str]]:
        """Each case and measure, in the order they were measured."""
        return list(dict.fromkeys((case, measure) for case, measure, _ in self.figures))

    def systems(self) -> list[str]:
        """Each system that was measured: the bare client, versions of the gateway, peers."""
        found = dict.fromkeys(system for _, _, system in self.figures)
        return sorted(found, key=lambda name: (name != BARE, name != OURS, not name.startswith(OURS)))

    def find(self, case: str, measure: str, system: str) -> Figure | None:
        """The figure of a system, if it has one."""
        return self.figures.get((case, measure, system))

    def ratio(self, case: str, measure: str, system: str, base: str) -> float | None:
        """The median of one system by that of another."""
        one, other = self.find(case, measure, system), self.find(case, measure, base)
        return one.value / other.value if one and other and other.value else None

    def document(self) -> dict[str, object]:
        """The figures, with ratios to the bare client, and what was left out, as JSON takes them."""
        figures = [
            {**vars(figure), "median": figure.value, "ratio_to_bare": self.ratio(*key, BARE)}
            for key, figure in self.figures.items()
        ]
        left_out = [
            {"system": system, "case": case, "reasons": reasons} for (system, case), reasons in self.left_out.items()
        ]
        return {"figures": figures, "left_out": left_out}


def percentile(ordered: Sequence[float], share: float) -> float:
    """A percentile of ordered values."""
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]
