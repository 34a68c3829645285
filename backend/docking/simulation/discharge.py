"""The discharge curve of a cell: its voltage by what has been taken out of it.

The model is Shepherd's in the form of Tremblay, Dessaint and Dekkiche, A Generic Battery Model for the Dynamic
Simulation of Hybrid Electric Vehicles (IEEE VPPC 2007), which also gives the way from the data sheet to its constants.
"""

import math
from dataclasses import dataclass

SECONDS_PER_HOUR = 3600.0


@dataclass(frozen=True, slots=True)
class DataSheet:
    """Data of a cell from its data sheet: points of its discharge curve at one current.

    Attributes:
        rated: Capacity that is promised, in Ah.
        maximum: Charge at which the curve falls to nothing, in Ah.
        full: Voltage at the beginning, in V.
        exponential: Voltage at the end of the first, steep part, in V.
        exponential_charge: Charge taken out by then, in Ah.
        nominal: Voltage at the end of the flat part, in V.
        nominal_charge: Charge taken out by then, in Ah.
        current: That the curve was measured at, in A.
        resistance: Inside, in ohm.
        cut_off: Voltage of an empty cell, in V.
        mass: In kg.
    """

    rated: float
    maximum: float
    full: float
    exponential: float
    exponential_charge: float
    nominal: float
    nominal_charge: float
    current: float
    resistance: float
    cut_off: float
    mass: float


HHR650D = DataSheet(
    rated=6.5,
    maximum=7.0,
    full=1.39,
    exponential=1.28,
    exponential_charge=1.3,
    nominal=1.18,
    nominal_charge=6.25,
    current=1.3,
    resistance=0.0046,
    cut_off=1.0,
    mass=0.17,
)
"""Panasonic's NiMH cell HHR650D, size D, discharged at a fifth of its capacity an hour. Seven of them make 9 V.

The points are those of the preset PANASONIC_HHR650D_NIMH of the network simulator ns-3 (src/energy; Gallegos Ramonet et
al., Evaluation and Extension of ns-3 Battery Framework, WNS3 2023), taken from the data sheet.
"""


class DischargeCurve:
    """E(q) = E0 - K Q / (Q - q) + A exp(-B q): the open voltage of a cell after q Ah have been taken out.

    Attributes:
        capacity: What can be taken out until the open voltage is down to the cut-off, in Ah.
        resistance: Of the cell, in ohm.
    """

    def __init__(self, sheet: DataSheet) -> None:
        self.resistance = sheet.resistance
        self._q = sheet.maximum
        self._a = sheet.full - sheet.exponential
        self._b = 3.0 / sheet.exponential_charge
        rise = self._a * (math.exp(-self._b * sheet.nominal_charge) - 1.0)
        flat = sheet.full - sheet.nominal + rise
        self._k = flat * (sheet.maximum - sheet.nominal_charge) / sheet.nominal_charge
        self._e0 = sheet.full + self._k + sheet.resistance * sheet.current - self._a
        # Where the curve meets the cut-off, the exponential part has long been over.
        self.capacity = self._q * (1.0 - self._k / (self._e0 - sheet.cut_off))

    def voltage(self, taken: float) -> float:
        """Open voltage, in V.

        Args:
            taken: Out of a full cell, in Ah, 0…capacity.
        """
        return self._e0 - self._k * self._q / (self._q - taken) + self._a * math.exp(-self._b * taken)

    def energy(self, taken: float) -> float:
        """Energy that is left above the empty cell, in J: the integral of the curve.

        Args:
            taken: Out of a full cell, in Ah, 0…capacity.
        """
        return SECONDS_PER_HOUR * (self._integral(self.capacity) - self._integral(taken))

    def _integral(self, taken: float) -> float:
        shrinking = self._k * self._q * math.log((self._q - taken) / self._q)
        return self._e0 * taken + shrinking + self._a / self._b * (1.0 - math.exp(-self._b * taken))
