import numpy as np
import pytest

from core.errors import DegenerateInput
from core.methods import diagnose
from core.truth import point_set

KINDS = {"branches-too-near", "branches-hidden", "turn-too-sharp", "gap-in-samples"}


def rings(gap, n, seed):
    """Two concentric circles, ``gap`` apart, in units of the noise."""
    rng = np.random.default_rng(seed)
    angle, radius = rng.uniform(0.0, 2 * np.pi, n), 30.0 + gap * rng.integers(0, 2, n)
    return np.column_stack((radius * np.cos(angle), radius * np.sin(angle))) + rng.normal(size=(n, 2))


@pytest.mark.parametrize("gap", [2.0, 3.0, 3.5])
def test_rings_too_near_each_other_are_not_compliant(gap):
    answer = diagnose(rings(gap, 3000, 1))
    assert not answer.sampling.nyquist.compliant
    assert "not good enough" in answer.verdict
    worst = answer.sampling.nyquist.violations[0]
    assert worst.kind in KINDS
    assert worst.gap_sigmas == pytest.approx(gap, rel=0.25)
    assert np.linalg.norm(worst.location) == pytest.approx(30.0 + gap / 2, abs=2.0)
    assert worst.reason
    assert worst.advice


@pytest.mark.parametrize("gap", [6.0, 6.5])
def test_rings_far_enough_from_each_other_are_compliant(gap):
    nyquist = diagnose(rings(gap, 3000, 2)).sampling.nyquist
    assert nyquist.compliant
    assert nyquist.margin_sigmas == pytest.approx(gap, rel=0.1)
    assert np.linalg.norm(nyquist.margin_location) == pytest.approx(30.0 + gap / 2, abs=2.0)


@pytest.mark.parametrize("name", ["circle", "figure_8", "star", "tilted", "t_junction"])
def test_sound_samples_are_told_to_be(name):
    sample = point_set(name, n=2000, sigma=0.005, seed=5)
    answer = diagnose(sample.points)
    assert answer.sampling.nyquist.violations == ()
    assert answer.verdict.startswith("The samples are good enough")
    assert answer.sampling.sigma == pytest.approx(sample.sigma, abs=5 * answer.sampling.sigma_error)


def test_a_gap_is_told_with_its_place():
    rng = np.random.default_rng(3)
    angle = rng.uniform(0.08, 2 * np.pi, 3000)
    points = np.column_stack((np.cos(angle), np.sin(angle))) + 0.01 * rng.normal(size=(3000, 2))
    sampling = diagnose(points).sampling
    violation = next(v for v in sampling.nyquist.violations if v.kind == "gap-in-samples")
    assert np.linalg.norm(violation.location - [np.cos(0.04), np.sin(0.04)]) < 0.05
    gap = sampling.largest_gap
    assert np.isfinite([gap.length, gap.spacings, gap.expected]).all()


def test_answers_follow_the_units():
    points = rings(3.0, 1500, 5)
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    one, other = diagnose(points).sampling, diagnose(1e3 * points @ turn.T + 7e3).sampling
    assert other.sigma == pytest.approx(1e3 * one.sigma, rel=0.05)
    assert other.sigma_error == pytest.approx(1e3 * one.sigma_error, rel=0.2)
    assert other.nyquist.compliant == one.nyquist.compliant


@pytest.mark.parametrize("scale", [1e-300, 1e300])
def test_the_ends_of_the_doubles_are_no_ends(scale):
    sampling = diagnose(0.005 * rings(3.0, 600, 6) * scale).sampling
    assert np.isfinite([sampling.sigma, sampling.sigma_error, sampling.density]).all()
    for violation in sampling.nyquist.violations:
        assert np.isfinite(violation.location).all()
        assert np.isfinite(violation.gap_sigmas)


def test_samples_without_noise_are_good_enough():
    angle = np.linspace(0.0, 2 * np.pi, 400, endpoint=False)
    sampling = diagnose(np.column_stack((np.cos(angle), np.sin(angle)))).sampling
    assert sampling.nyquist.compliant
    assert sampling.sigma < 1e-3


@pytest.mark.parametrize("n", [6, 8, 12, 20, 40, 100])
def test_few_samples_are_answered(n):
    points = point_set("ellipse", n=n, sigma=0.01, seed=n).points
    try:
        sampling = diagnose(points).sampling
    except DegenerateInput:
        return
    assert np.isfinite([sampling.sigma, sampling.density]).all()
    assert all(violation.kind in KINDS for violation in sampling.nyquist.violations)
