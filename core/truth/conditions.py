"""How a sample departs from the plain case: independent, uniform positions and Gaussian noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from core.errors import InvalidParameter

__all__ = ["PLAIN", "Conditions", "OutlierPattern", "Spacing"]

OutlierPattern = Literal["uniform", "clustered"]
Spacing = Literal["random", "even"]

_RANGES = {
    "noise_ratio": (1.0, 100.0),
    "density_ratio": (1.0, 1000.0),
    "blocks": (0, 1000),
    "degrees_of_freedom": (1.0, float("inf")),
    "quantum": (0.0, 100.0),
    "duplicates": (0.0, 1.0),
}


@dataclass(frozen=True, slots=True)
class Conditions:
    """What makes a sample harder; the defaults change nothing, down to the last bit.

    Conditions draw from a random stream of their own: the same seed gives the same positions and the
    same Gaussian deviates with and without them, wherever they do not ask for others.

    Attributes
    ----------
    noise_ratio : float
        Largest noise along a curve over the smallest, 1 to 100. In between the logarithm of the noise
        runs like a cosine: once around a closed curve, from end to end of an open one. The mean square
        along the curve stays sigma squared.
    density_ratio : float
        Densest place along a curve over the sparsest, 1 to 1000; runs likewise, independently.
    blocks : int
        When not 0: so many pieces of equal length along each curve, dense and sparse by turns, instead
        of a smooth run. 0 to 1000.
    outliers : {"uniform", "clustered"}
        Clustered ones come in blobs of some forty, every other one near a curve.
    degrees_of_freedom : float
        Of a Student t distribution of the noise, 1 to infinity (Gaussian). The same in every direction,
        and as wide in its middle as the Gaussian: half of its mass lies within 0.6745 sigma in each
        coordinate. Its standard deviation, where there is one, is larger: 1.53 sigma for 3 degrees.
    quantum : float
        All coordinates are rounded to a grid of this step, in units of sigma, 0 to 100; 0 for none.
    duplicates : float
        Exact copies of points, as a fraction (0 to 1) of the points; they come on top.
    spacing : {"random", "even"}
        Even spacing draws one place from each of n equal parts, so that no gap is wider than two.

    Raises
    ------
    InvalidParameter
        For a value out of range, at ``("conditions", <name>)``.
    """

    noise_ratio: float = 1.0
    density_ratio: float = 1.0
    blocks: int = 0
    outliers: OutlierPattern = "uniform"
    degrees_of_freedom: float = float("inf")
    quantum: float = 0.0
    duplicates: float = 0.0
    spacing: Spacing = "random"

    def __post_init__(self) -> None:
        for name, (low, high) in _RANGES.items():
            if not low <= getattr(self, name) <= high:
                raise InvalidParameter(f"{name} must be between {low} and {high}.", ("conditions", name))
        for name, allowed in (("outliers", ("uniform", "clustered")), ("spacing", ("random", "even"))):
            if getattr(self, name) not in allowed:
                raise InvalidParameter(f"{name} is one of {', '.join(allowed)}.", ("conditions", name))

    @property
    def moves_positions(self) -> bool:
        """Whether positions along the curves are other than independent and as the family has them."""
        return self.density_ratio != 1.0 or self.spacing != "random"


PLAIN = Conditions()
