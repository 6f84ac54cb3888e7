import numpy as np
import pytest

from core.surface.noding import noded
from core.surface.parameters import SurfaceParameters
from core.surface.regions import regions_of
from core.surface.similarity import gated
from core.surface.skin import surface_of
from tests.core.surface.contours import ring, square, stack


def components(levels, similarity):
    report = surface_of(levels, SurfaceParameters(similarity=similarity, method="slabs")).report
    assert report.closed
    assert report.manifold
    assert report.self_intersections == 0
    return report.components


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_contours_are_connected_from_their_shared_area_on(share):
    levels = stack([square(0.0, 0.0, 1.0)], [square(1.0 - share, 0.0, 1.0)])
    assert components(levels, share - 0.01) == 1
    assert components(levels, share + 0.01) == 2


def test_the_smaller_contour_decides():
    levels = stack([ring(4.0)], [ring(1.0, (2.0, 0.0))])
    assert components(levels, 1.0) == 1


def test_a_refused_neighbour_ends_and_the_others_go_on():
    low, high = [ring(1.0)], [ring(0.9), ring(0.5, (1.45, 0.0))]
    levels = stack(low, high)
    assert components(levels, 0.0) == 1
    assert components(levels, 0.6) == 2
    # Far from what is refused, nothing changes.
    far = [ring(1.0, (9.0, 0.0))]
    one = surface_of(stack([*low, *far], [*high, *far]), SurfaceParameters(similarity=0.6)).mesh
    other = surface_of(stack(far, far), SurfaceParameters(similarity=0.6)).mesh
    assert np.ptp(one.vertices[one.vertices[:, 0] > 7.0], axis=0) == pytest.approx(
        np.ptp(other.vertices, axis=0), abs=1e-4
    )


def test_intermediate_levels_hold_accepted_overlaps_only():
    levels = stack(
        [square(0.0, 0.0, 1.0), square(1.5, 0.0, 1.0)], [square(0.1, 0.0, 1.0), square(1.2, 0.0, 0.4)]
    )
    lines = gated(noded(regions_of(levels, np.eye(3)).lines), 4, 0.5)
    middle = lines.ends[lines.level == 3]
    assert len(middle) == 0
    lines = gated(noded(regions_of(levels, np.eye(3)).lines), 4, 0.1)
    assert not lines.gated.any()
    refused = stack([square(0.0, 0.0, 1.0)], [square(0.1, 0.0, 0.5), square(0.9, 0.0, 0.4)])
    lines = gated(noded(regions_of(refused, np.eye(3)).lines), 4, 0.5)
    assert lines.gated[lines.level == 2, 1].all()
    assert lines.gated[lines.level == 4, 0].all()
    xs = regions_of(refused, np.eye(3)).grid.placed(lines.ends[lines.level == 3].reshape(-1, 2))[:, 0]
    assert (xs.min(), xs.max()) == pytest.approx((0.1, 0.6), abs=1e-5)
