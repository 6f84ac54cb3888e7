import numpy as np
import pytest

from core.cloud.lattice import lattice_step
from core.cloud.points import distinct
from tests.core.shapes import arc, rotation


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_rounded_coordinates_are_seen_in_any_frame(scale):
    step = 0.02 * scale
    rounded = np.round(scale * arc(3000, 0.03) / step) * step
    turned = rounded @ rotation(np.random.default_rng(1), 2).T
    for points in (rounded, turned):
        assert lattice_step(distinct(np.pad(points, ((0, 0), (0, 1))))) == pytest.approx(step, rel=1e-5)


def test_samples_that_were_not_rounded_are_on_no_lattice():
    assert lattice_step(arc(3000, 0.03)) is None
    assert lattice_step(np.zeros((1, 2))) is None
