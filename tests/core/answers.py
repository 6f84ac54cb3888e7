"""What several tests ask of an answer."""

import numpy as np

from core.results import Curve
from core.truth import score
from tests.core.shapes import deviation


def scored(answer, sample, reading="through"):
    """The score of an answer against the truth of its sample."""
    return score([(c.vertices, c.closed) for c in answer.curves], sample, reading=reading)


def topology(answer):
    """Whether each curve is closed, open ones first."""
    return sorted(c.closed for c in answer.curves)


def same_curves(one, two):
    """Largest distance between the curves of two answers, each with its nearest of the same kind."""
    assert topology(one) == topology(two)
    return max(min(deviation(a, b) for b in two.curves if a.closed == b.closed) for a in one.curves)


def moved_back(answer, back):
    """The curves of an answer in the frame of another."""
    curves = [Curve(back(c.vertices), c.closed, c.component, c.length, c.samples, 0.0) for c in answer.curves]
    return type("Answer", (), {"curves": curves})


def assert_sound(answer, points):
    """Curves, crossings, labels and sampling are such as a reader may rely on."""
    points = np.asarray(points, np.float64)
    low, high = points.min(axis=0) / 4, points.max(axis=0) / 4
    extent = float((high - low).max())
    assert answer.curves
    for curve in answer.curves:
        assert curve.vertices.ndim == 2
        assert curve.vertices.shape[1] == points.shape[1]
        assert len(curve.vertices) >= (3 if curve.closed else 2)
        assert np.isfinite(curve.vertices).all()
        # No curve leaves its samples by more than their own extent.
        assert np.all(curve.vertices / 4 >= low - extent - 5e-324)
        assert np.all(curve.vertices / 4 <= high + extent + 5e-324)
        assert np.isfinite([curve.length, curve.rms_residual]).all()
        assert 0 <= curve.samples <= len(points)
    for crossing in answer.crossings:
        assert np.isfinite(crossing.location).all()
        assert 0.0 <= crossing.angle <= 90.0
    assert answer.labels.shape == (len(points),)
    assert answer.labels.max() < len(answer.curves)
    assert np.array_equal(np.unique(answer.outliers), answer.outliers)
    sampling = answer.sampling
    assert np.isfinite([sampling.sigma, sampling.density, sampling.epsilon]).all()
    assert sampling.sigma >= 0.0
    assert sampling.density >= 0.0
