"""Violations in words and figures, in the user's frame and units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.cloud.points import LARGEST
from core.cloud.working_frame import WorkingFrame
from core.diagnosis.across import Across
from core.diagnosis.branches import LEAST_GAP
from core.diagnosis.gaps import Gap
from core.diagnosis.hidden import Hidden
from core.diagnosis.meetings import Doubt
from core.diagnosis.turns import Turn
from core.results import Violation

__all__ = ["Wording", "facing", "near"]

Floats = NDArray[np.float64]

QUIETER = "average scans or measure more precisely"
QUIETER_BY = 0.8  # at least


@dataclass(frozen=True, slots=True, eq=False)
class Wording:
    """Tells what was found about one component.

    Attributes
    ----------
    frame : WorkingFrame
        Its way back to the user's coordinates.
    sigma : float
        Its noise, in working units.
    """

    frame: WorkingFrame
    sigma: float

    def place(self, x: Floats) -> Floats:
        """(d,) user's coordinates of a place (3,) in working coordinates."""
        return np.asarray(self.frame.restore(x[None])[0])

    def near(self, x: Floats, gap: float) -> Violation:
        """Two branches that are told apart, but too near."""
        return near(self.place(x), gap, self.sigma, self.frame.scale)

    def crossed(self, doubt: Doubt) -> Violation:
        """Two branches that may cross or not."""
        place, sigmas = self.place(doubt.place), doubt.gap / self.sigma
        return Violation(
            place,
            float(sigmas),
            f"two branches near {_at(place)} may cross, or keep some {sigmas:.1f} sigma apart: the "
            f"noise does not let that be told",
            "branches-too-near",
            f"{QUIETER} near {_at(place)}, to bring the noise from {self._length(self.sigma)} below "
            f"{self._length(doubt.gap / LEAST_GAP)}, or give the two branches as separate point sets",
        )

    def hidden(self, across: Across, found: Hidden) -> Violation:
        """One curve for two branches."""
        place = self._on(across, 0.5 * (found.low + found.high))
        sigmas = found.gap / max(found.sigma, 1e-300)
        wanted = min(found.gap / LEAST_GAP, QUIETER_BY * found.sigma)
        return Violation(
            place,
            float(sigmas),
            f"along {self._length(found.high - found.low)} of curve about {_at(place)} samples lie as if "
            f"there were two branches some {sigmas:.1f} sigma apart",
            "branches-hidden",
            f"if there are two branches {self._length(found.gap)} apart near {_at(place)}, {QUIETER} to "
            f"bring the noise from {self._length(found.sigma)} below {self._length(wanted)}, "
            f"or give them as separate point sets",
        )

    def turn(self, across: Across, turn: Turn) -> Violation:
        """A turn that the noise blurs."""
        place, sigmas = self._on(across, turn.station), turn.height / across.sigma
        return Violation(
            place,
            float(sigmas),
            f"near {_at(place)} the curve passes by a detail {sigmas:.1f} sigma high, which the noise does "
            f"not let it follow",
            "turn-too-sharp",
            f"{QUIETER} near {_at(place)}, to bring the noise from {self._length(across.sigma)} below "
            f"{self._length(min(0.25 * turn.height, 0.5 * across.sigma))}, or scan denser there",
        )

    def bridged(self, across: Across, gap: Gap) -> Violation:
        """A stretch of curve without samples."""
        place = self._on(across, gap.middle)
        sigmas = min(gap.length / across.sigma, LARGEST) if across.sigma > 1e-300 else LARGEST
        with np.errstate(over="ignore"):
            density = min(gap.expected / gap.length / self.frame.scale, LARGEST)
        return Violation(
            place,
            float(sigmas),
            f"the curve passes over {self._length(gap.length)} without a sample near {_at(place)}: "
            f"{gap.spacings:.0f} mean distances between samples, of which independent ones leave at most "
            f"{gap.expected:.0f}",
            "gap-in-samples",
            f"scan the gap near {_at(place)}; were samples only sparse there, fewer than {density:.3g} in a "
            f"unit of length would leave such a gap by chance",
        )

    def thin(self, across: Across, middle: float, length: float) -> Violation:
        """A gap that noise has blurred."""
        place, sigmas = self._on(across, middle), length / across.sigma
        return Violation(
            place,
            float(sigmas),
            f"the curve passes over {self._length(length)} or more near {_at(place)} with less than half of "
            f"the samples that there are either side, and noise from there may be all of them",
            "gap-in-samples",
            f"scan the gap near {_at(place)}",
        )

    def _on(self, across: Across, station: float) -> Floats:
        return self.place(across.line.at(np.array([station]))[0])

    def _length(self, x: float) -> str:
        """A length in the user's units, in words."""
        return f"{min(x * self.frame.scale, LARGEST):.3g}"


def _at(place: Floats) -> str:
    return f"({', '.join(f'{x:.4g}' for x in place)})"


def near(place: Floats, gap: float, sigma: float, scale: float) -> Violation:
    """Two branches that are told apart, but too near; lengths in units of ``scale``."""
    sigmas = gap / sigma
    wanted, noise = (min(x * scale, LARGEST) for x in (gap / LEAST_GAP, sigma))
    return Violation(
        place,
        float(sigmas),
        f"two branches are only {sigmas:.1f} sigma apart near {_at(place)}, and nearer than "
        f"{LEAST_GAP:g} sigma they cannot be told apart reliably",
        "branches-too-near",
        f"{QUIETER} near {_at(place)}, to bring the noise from {noise:.3g} below {wanted:.3g}, or give the "
        f"two branches as separate point sets",
    )


def facing(place: Floats, sigmas: float, gap: float, spacings: float, expected: float) -> Violation:
    """Two ends over a gap, in the user's frame and units."""
    return Violation(
        place,
        sigmas,
        f"two open ends face each other near {_at(place)} over {gap:.3g} without a sample: {spacings:.0f} "
        f"mean distances between samples, of which independent ones leave at most {expected:.0f}",
        "gap-in-samples",
        f"scan the gap near {_at(place)} if the curve goes on there",
    )
