"""The floor: the best that a local regression can do when it is told each sample's true parameter.

Local quadratic regression of each coordinate on the true arc length, with the one bandwidth per
curve that minimises the true error (Fan and Gijbels, Local Polynomial Modelling, 1996, ch. 3).
No reconstruction from points alone can be expected to beat it by much.

What the oracle is told of harder samples (:class:`core.truth.conditions.Conditions`):

* which samples are outliers, and which are copies: they weigh together what one sample weighs;
* the noise at each sample where it varies along the curve: weights are its inverse square, where that
  helps (at one bandwidth they shift a window's middle). It varies slowly, so that it can be learnt;
* the distribution of heavy tails, not the luck of each draw. Each residual r is replaced by
  psi(r) / I, the score of the multivariate t distribution over its Fisher information: regression on
  these is one Newton step of maximum likelihood from the truth, which attains the Cramer-Rao bound
  (Lange, Little and Taylor, J. Am. Stat. Assoc. 84, 1989). Told each draw's own scale it would
  fall below what anybody can reach, by a fifth for 3 degrees of freedom.

It keeps one bandwidth per curve; where noise or density vary, bandwidths that vary may gain a few per cent.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft

from core.truth.metrics import distances, rms, true_points
from core.truth.point_sets import PointSet, TrueCurve
from core.truth.sampling import t_scale

__all__ = ["local_quadratic", "oracle_curves", "oracle_rms"]

Floats = NDArray[np.float64]

_BINS = 4096
_RATIO = 1.08  # between bandwidths tried; the error is flat at its minimum
_COARSE = 4
_FEWEST = 6.0  # samples that every window must hold


def oracle_rms(sample: PointSet) -> float:
    """Return the RMS distance from the true curves to their oracle estimates, in units of the points.

    The distance is that of :attr:`core.truth.metrics.Score.rms`; several curves are pooled by length.
    Infinite when some curve has too few samples for any regression.
    """
    estimates = oracle_curves(sample)
    if any(one is None for one in estimates):
        return float("inf")
    known = [
        (one, curve.closed) for one, curve in zip(estimates, sample.curves, strict=True) if one is not None
    ]
    return rms(distances(true_points(sample.curves), known))


def oracle_curves(sample: PointSet) -> list[Floats | None]:
    """Return the oracle's estimate of each true curve as (M, d) vertices; None for too few samples."""
    return [_best(_told(sample, k), one) for k, one in enumerate(sample.curves)]


@dataclass(frozen=True, slots=True, eq=False)
class _Told:
    """What the oracle knows of the samples of one curve; weights None where all are alike."""

    u: Floats
    points: Floats
    weights: Floats | None


def _told(sample: PointSet, k: int) -> _Told:
    """Return the samples of one curve, with copies and tails taken out as the module says."""
    here = np.flatnonzero(sample.curve_of == k)
    if sample.conditions.duplicates:
        here = here[np.unique(sample.u[here], return_index=True)[1]]
    u, points, noise = sample.u[here], sample.points[here], sample.noise[here]
    if not np.isinf(sample.conditions.degrees_of_freedom) and sample.sigma > 0:
        exact = sample.curves[k].exact.at(u)
        points = exact + _efficient(points - exact, noise, sample.conditions.degrees_of_freedom)
    varies = sample.conditions.noise_ratio > 1.0 and sample.sigma > 0
    return _Told(u, points, (sample.sigma / noise) ** 2 if varies else None)


def _efficient(residuals: Floats, noise: Floats, nu: float) -> Floats:
    """Return the score of t-distributed residuals (M, d) over its Fisher information."""
    scale, d = noise[:, None] * t_scale(nu), residuals.shape[1]
    reduced = (residuals / scale) ** 2
    score = (nu + d) * residuals / (nu + reduced.sum(axis=1, keepdims=True))
    return np.asarray(score * (nu + d + 2) / (nu + d))


def _best(told: _Told, curve: TrueCurve) -> Floats | None:
    """Return the estimate with the smallest error, with weights or without them."""
    error = _NormalError.of(curve)
    tried = [_Bins.of(told.u, told.points, curve.closed)]
    if told.weights is not None:
        tried.append(_Bins.of(told.u, told.points, curve.closed, told.weights))
    return min((_over_widths(bins, error) for bins in tried), key=error)


def _over_widths(bins: _Bins, error: _NormalError) -> Floats | None:
    """Try bandwidths on a geometric grid, coarse and then fine, and keep the one with the smallest error."""
    widths = _widths(bins.closed)
    tried: dict[int, float] = {}

    def attempt(k: int) -> float:
        if k not in tried:
            tried[k] = error(bins.regress(widths[k])) if 0 <= k < len(widths) else np.inf
        return tried[k]

    coarse = min(range(0, len(widths), _COARSE), key=attempt)
    best = min(range(coarse - _COARSE + 1, coarse + _COARSE), key=attempt)
    return bins.regress(widths[best]) if np.isfinite(attempt(best)) else None


def _widths(closed: bool) -> Floats:
    """Half-widths of the kernel to try, in fractions of the arc length, ascending."""
    largest = 0.5 if closed else 1.0
    count = int(np.log(largest / 0.003) / np.log(_RATIO))
    count += -count % _COARSE  # so that the coarse grid holds the widest, the only one for few samples
    return np.asarray(largest * _RATIO ** np.arange(-count, 1.0))


@dataclass(frozen=True, slots=True, eq=False)
class _NormalError:
    """RMS of the part of an estimate's error that is normal to the curve: to first order its distance."""

    exact: Floats
    tangent: Floats

    @classmethod
    def of(cls, curve: TrueCurve) -> _NormalError:
        parameters = curve.exact.parameter(np.linspace(0.0, 1.0, _BINS, endpoint=not curve.closed))
        return cls(curve.exact.evaluate(parameters), curve.exact.tangent(parameters))

    def __call__(self, estimate: Floats | None) -> float:
        if estimate is None:
            return np.inf
        gap = estimate - self.exact
        along = np.einsum("ij,ij->i", gap, self.tangent)
        squares = np.einsum("ij,ij->i", gap, gap) - along**2
        return float(np.sqrt(max(0.0, float(np.mean(squares)))))


def local_quadratic(u: Floats, values: Floats, closed: bool, width: float) -> Floats | None:
    """Regress values on u by local parabolas at 4096 equidistant places.

    Parameters
    ----------
    u : (N,) array
        Parameters between 0 and 1; periodic when closed.
    values : (N, d) array
    closed : bool
    width : float
        Half-width of the Epanechnikov kernel.

    Returns
    -------
    (4096, d) array or None
        Estimates at bin centres (closed) or from u = 0 to u = 1 (open); None when a window holds
        fewer than six samples.
    """
    return _Bins.of(u, values, closed).regress(width)


@dataclass(frozen=True, slots=True, eq=False)
class _Bins:
    """Samples shared linearly between equidistant nodes, in the frequency domain.

    Weighted moments in a window are convolutions of the kernel's powers with these sums, so that a
    regression costs O(B log B) for B nodes however many samples there are.
    """

    size: int
    spacing: float
    closed: bool
    transforms: NDArray[np.complex128]  # of the sums of weights and weighted values
    numbers: NDArray[np.complex128]  # of the numbers of samples

    @classmethod
    def of(cls, u: Floats, values: Floats, closed: bool, weights: Floats | None = None) -> _Bins:
        spacing = 1.0 / (_BINS if closed else _BINS - 1)
        place = u / spacing
        left = np.clip(np.floor(place).astype(np.int64), 0, _BINS - 1 if closed else _BINS - 2)
        share = place - left
        right = (left + 1) % _BINS
        one = np.ones(len(u))
        columns = [one, *values.T] if weights is None else [weights, *(weights * c for c in values.T), one]
        sums = [
            np.bincount(left, (1 - share) * c, _BINS) + np.bincount(right, share * c, _BINS) for c in columns
        ]
        size = _BINS if closed else next_fast_len(2 * _BINS, real=True)
        every = rfft(np.array(sums), size)
        if weights is None:
            return cls(size, spacing, closed, every, every[0])
        return cls(size, spacing, closed, every[:-1], every[-1])

    def regress(self, width: float) -> Floats | None:
        offset = np.fft.fftfreq(self.size, 1.0 / self.size) * self.spacing / width
        kernel = np.maximum(0.0, 1.0 - offset**2)
        powers = rfft(kernel * offset ** np.arange(5)[:, None], self.size).conj()  # correlation
        counts = irfft(powers * self.transforms[0], self.size)[:, :_BINS]
        box = rfft((kernel > 0).astype(float), self.size).conj()
        if irfft(box * self.numbers, self.size)[:_BINS].min() < _FEWEST:
            return None
        moments = irfft(powers[:3, None] * self.transforms[None, 1:], self.size)[:, :, :_BINS]
        return _intercepts(counts, moments)


def _intercepts(c: Floats, moments: Floats) -> Floats | None:
    """Solve the normal equations of all windows for the value of each parabola at its centre.

    ``c`` (5, B) are the kernel moments 0 to 4 of the samples, ``moments`` (3, d, B) those of the values.
    """
    first = c[2] * c[4] - c[3] * c[3]
    second = c[2] * c[3] - c[1] * c[4]
    third = c[1] * c[3] - c[2] * c[2]
    determinant = c[0] * first + c[1] * second + c[2] * third
    if not np.all(determinant > 1e-9 * c[0] ** 3):
        return None
    return np.asarray((first * moments[0] + second * moments[1] + third * moments[2]) / determinant).T.copy()
