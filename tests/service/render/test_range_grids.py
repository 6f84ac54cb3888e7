"""Range images as files: what is written is read back."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from core.surface.results import Pose, RangeImage
from service.intake.range_ply import decode_conf, decode_range_ply, is_range_ply
from service.render.range_grids import write_conf, write_range_ply


@settings(deadline=None)
@given(st.integers(1, 7), st.integers(1, 7), st.floats(0.0, 1.0), st.integers(0, 2**32 - 1))
def test_a_grid_comes_back_in_single_precision(rows: int, columns: int, holes: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(rows, columns, 3))
    points[rng.uniform(size=(rows, columns)) < holes] = np.nan
    content = write_range_ply(RangeImage(points))
    assert is_range_ply(content)
    back = decode_range_ply(content).points
    assert np.array_equal(back, points.astype(np.float32), equal_nan=True)


@pytest.mark.parametrize("seed", range(5))
def test_poses_come_back(seed: int) -> None:
    rng = np.random.default_rng(seed)
    poses = {
        f"scan{k}.ply": Pose(Rotation.random(rng=rng).as_matrix(), 100.0 * rng.normal(size=3))
        for k in range(4)
    }
    back = decode_conf(write_conf(poses))
    assert back.keys() == poses.keys()
    for name, pose in poses.items():
        assert np.allclose(back[name].rotation, pose.rotation, atol=1e-12)
        assert np.array_equal(back[name].translation, pose.translation)
