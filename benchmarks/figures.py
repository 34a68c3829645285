"""Figures: what was measured, of whom. Plain data."""

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, field

BARE, OURS = "bare rclpy", "dock-gateway"


@dataclass(frozen=True)
class Figure:
    """One number of one system; `note` says why there is none, or what to know about it."""

    case: str
    measure: str
    system: str
    value: float | None
    unit: str = "ms"
    note: str = ""


@dataclass
class Results:
    """All figures of a run."""

    figures: list[Figure] = field(default_factory=list)

    def add(
        self, case: str, measure: str, system: str, value: float | None, *, unit: str = "ms", note: str = ""
    ) -> None:
        """Add a figure."""
        self.figures.append(Figure(case, measure, system, value, unit, note))

    def latencies(self, case: str, what: str, system: str, samples: Iterable[float]) -> None:
        """Add median and 99th percentile of some latencies."""
        values = sorted(samples)
        for name, share in (("p50", 0.5), ("p99", 0.99)):
            self.add(
                case, f"{what} {name}".strip(), system, percentile(values, share), note="" if values else "no answer"
            )

    def missing(self, case: str, measure: str, system: str, why: str) -> None:
        """Say why there is no figure."""
        self.add(case, measure, system, None, unit="", note=why)

    def rows(self) -> list[tuple[str, str]]:
        """Each case and measure, in the order they were measured."""
        return list(dict.fromkeys((figure.case, figure.measure) for figure in self.figures if figure.value is not None))

    def systems(self) -> list[str]:
        """Each system: the bare client, versions of the gateway, peers."""
        found = dict.fromkeys(figure.system for figure in self.figures)
        return sorted(found, key=lambda name: (name != BARE, name != OURS, not name.startswith(OURS)))

    def find(self, case: str, measure: str, system: str) -> Figure | None:
        """The figure of a system, or the note why it has none."""
        exact = [f for f in self.figures if (f.case, f.system) == (case, system) and f.measure in (measure, "")]
        return exact[-1] if exact else None

    def ratio(self, case: str, measure: str, system: str, base: str) -> float | None:
        """A figure of one system by that of another."""
        one, other = self.find(case, measure, system), self.find(case, measure, base)
        if one is None or other is None or one.value is None or not other.value:
            return None
        return one.value / other.value

    def document(self) -> list[dict[str, object]]:
        """The figures, with ratios to the bare client, as JSON takes them."""
        return [
            {**asdict(figure), "ratio_to_bare": self.ratio(figure.case, figure.measure, figure.system, BARE)}
            for figure in self.figures
        ]


def percentile(ordered: Sequence[float], share: float) -> float | None:
    """A percentile of ordered values."""
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))] if ordered else None
