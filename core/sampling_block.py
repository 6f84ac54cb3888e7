"""What the data say of themselves: the sampling block of every answer.

Coordinates and lengths are in the frame and the units of the input.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["ComponentSampling", "CurveGap", "Nyquist", "Sampling", "SigmaAlong", "Violation"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Violation:
    """A place where the sample is not Nyquist-compliant (§1).

    Attributes
    ----------
    location : (d,) array
    gap_sigmas : float
        Size of the detail there, in units of sigma.
    reason : str
        What is wrong, in one sentence.
    kind : str
        Stable name: ``branches-too-near``, ``branches-hidden``, ``turn-too-sharp`` or ``gap-in-samples``.
    advice : str
        What to do about it.
    """

    location: Floats
    gap_sigmas: float
    reason: str
    kind: str = "branches-too-near"
    advice: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Nyquist:
    """Whether the noise is below half of the smallest detail (§1), and by what margin.

    ``margin_sigmas`` is the smallest distance between branches that are not neighbours along a curve,
    in sigma; None when none come near.
    """

    compliant: bool
    margin_sigmas: float | None
    violations: tuple[Violation, ...] = ()
    margin_location: Floats | None = None


@dataclass(frozen=True, slots=True, eq=False)
class SigmaAlong:
    """Noise that varies along a curve: ``sigma`` (K,) at the places ``locations`` (K, d)."""

    curve: int
    locations: Floats
    sigma: Floats


@dataclass(frozen=True, slots=True, eq=False)
class CurveGap:
    """The longest stretch of a curve without a sample: its middle, its length, and that in units of 1 / rho.

    ``expected`` is what the largest of as many independent samples would be exceeded by in one set of
    a hundred, in the same units.
    """

    location: Floats
    curve: int
    length: float
    spacings: float
    expected: float


@dataclass(frozen=True, slots=True, eq=False)
class ComponentSampling:
    """What the samples of one component say of themselves; see :class:`Sampling`."""

    label: int
    size: int
    sigma: float
    sigma_error: float | None
    density: float


@dataclass(frozen=True, slots=True, eq=False)
class Sampling:
    """What the data say of themselves.

    Attributes
    ----------
    sigma : float
        Noise standard deviation normal to the curve, all components together.
    density : float
        Samples per unit length.
    epsilon : float
        The hop that made the partition.
    nyquist : Nyquist
    sigma_error : float or None
        Standard error of sigma.
    sigma_along : tuple of SigmaAlong
        One entry for each curve along which the noise varies significantly.
    largest_gap : CurveGap or None
        Along the curves, in units of 1 / rho.
    components : tuple of ComponentSampling
    """

    sigma: float
    density: float
    epsilon: float
    nyquist: Nyquist
    sigma_error: float | None = None
    sigma_along: tuple[SigmaAlong, ...] = ()
    largest_gap: CurveGap | None = None
    components: tuple[ComponentSampling, ...] = ()
