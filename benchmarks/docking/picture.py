"""All trails from above as an SVG."""

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise

from benchmarks.docking.trial import REGIONS, Trial
from docking.parameters import ControllerName
from docking.simulation.dock import DOCKED, DockSettings

SCALE = 200.0
"""Pixels a metre."""
MARGIN = 30.0
"""In pixels."""
KEPT = 0.006
"""How far a trail may be off its picture, in m."""
COLORS = {"docked at once": "#2563eb", "docked after a retry": "#d97706", "not docked": "#dc2626"}

Point = tuple[float, float]


def picture(trials: Mapping[ControllerName, Sequence[Trial]]) -> str:
    """The panels of all controllers side by side; x into the dock is to the right, y is upwards."""
    panels, left, height = [], MARGIN, 0.0
    for controller, some in trials.items():
        reach = REGIONS[controller].farthest + 0.15
        width, tall = (reach + 0.3) * SCALE, 2.0 * max(0.75, reach * math.sin(REGIONS[controller].off)) * SCALE
        panels.append((controller, some, left + reach * SCALE, tall))
        left += width + MARGIN
        height = max(height, tall)
    body = [line for controller, some, x, _ in panels for line in _panel(controller, some, x, 0.5 * height + 50.0)]
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {left:.0f} {height + 80.0:.0f}">',
            "<style>text { font: 14px sans-serif }</style>",
            "<title>Trails of the simulated robot from random starts to the dock</title>",
            '<rect width="100%" height="100%" fill="#fff"/>',
            *body,
            "</svg>\n",
        ]
    )


def _panel(controller: ControllerName, trials: Sequence[Trial], x: float, y: float) -> list[str]:
    """One controller; (x, y) is where the marker is in the picture."""
    region, dock = REGIONS[controller], DockSettings()
    far = region.farthest * SCALE
    corner_x, corner_y = far * math.cos(region.off), far * math.sin(region.off)
    outline = f"M0 0L{-corner_x:.0f} {-corner_y:.0f}A{far:.0f} {far:.0f} 0 0 0 {-corner_x:.0f} {corner_y:.0f}Z"
    box = [round(length * SCALE) for length in (dock.front, -0.5 * dock.width, dock.depth, dock.width)]
    lines = [
        f'<g transform="translate({x:.0f} {y:.0f})">',
        f'<path d="{outline}" fill="#f1f5f9"/>',
        f'<text x="{-far:.0f}" y="{-y + 30:.0f}">{controller}: {len(trials)} starts</text>',
        *(
            f'<text x="{-far:.0f}" y="{-y + 50 + 20 * line:.0f}" fill="{color}">{kind}</text>'
            for line, (kind, color) in enumerate(COLORS.items())
        ),
        f'<path d="M{-far:.0f} {y - 75:.0f}h{SCALE:.0f}m0 -4v8m{-SCALE:.0f} 0v-8" stroke="#000"/>',
        f'<text x="{-far + 0.5 * SCALE:.0f}" y="{y - 80:.0f}" text-anchor="middle">1 m</text>',
    ]
    for kind, color in COLORS.items():
        opacity = 0.12 if kind == "docked at once" else 0.6
        lines.append(f'<g fill="none" stroke="{color}" stroke-opacity="{opacity}">')
        lines += [f'<path d="{_path(trial.trail)}"/>' for trial in trials if _kind(trial) == kind]
        lines.append("</g>")
    starts = "".join(f"M{trial.trail[0][0] * SCALE:.0f} {-trial.trail[0][1] * SCALE:.0f}h0" for trial in trials)
    lines += [
        f'<path d="{starts}" stroke="#475569" stroke-width="3" stroke-linecap="round"/>',
        f'<rect x="{box[0]}" y="{box[1]}" width="{box[2]}" height="{box[3]}" fill="#334155"/>',
        f'<circle cx="{DOCKED.x * SCALE:.0f}" r="{0.15 * SCALE:.0f}" fill="none" stroke="#000" stroke-width="1.5"/>',
        "</g>",
    ]
    return lines


def _kind(trial: Trial) -> str:
    if not trial.docked:
        return "not docked"
    return "docked after a retry" if trial.retries else "docked at once"


def _path(trail: Sequence[Point]) -> str:
    points = [(round(x * SCALE), round(-y * SCALE)) for x, y in _simplified(list(trail))]
    moves = (f"l{b[0] - a[0]} {b[1] - a[1]}" for a, b in pairwise(points) if a != b)
    return f"M{points[0][0]} {points[0][1]}" + "".join(moves)


def _simplified(trail: list[Point]) -> list[Point]:
    """Without the points that do not matter (Douglas and Peucker, 1973)."""
    first, last = trail[0], trail[-1]
    if len(trail) < 3:
        return trail
    length = math.dist(first, last)

    def off(point: Point) -> float:
        if length < KEPT:
            return math.dist(first, point)
        across = (last[0] - first[0]) * (point[1] - first[1]) - (last[1] - first[1]) * (point[0] - first[0])
        return abs(across) / length

    farthest = max(range(1, len(trail) - 1), key=lambda place: off(trail[place]))
    if off(trail[farthest]) < KEPT:
        return [first, last]
    return _simplified(trail[: farthest + 1])[:-1] + _simplified(trail[farthest:])
