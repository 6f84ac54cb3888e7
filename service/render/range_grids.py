"""Range images as Stanford PLY range grids, and the ``.conf`` file with their poses."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from core.surface.results import Pose, RangeImage

__all__ = ["write_conf", "write_range_ply"]

_HEADER = """ply
format binary_little_endian 1.0
obj_info num_cols {columns}
obj_info num_rows {rows}
element vertex {vertices}
property float x
property float y
property float z
element range_grid {pixels}
property list uchar int vertex_indices
end_header
"""


def write_range_ply(image: RangeImage) -> bytes:
    """Write the points of a range image in single precision, in the scanner's own frame."""
    rows, columns = image.points.shape[:2]
    points = image.points.reshape(-1, 3)
    seen: NDArray[np.bool_] = np.all(np.isfinite(points), axis=1)
    header = _HEADER.format(rows=rows, columns=columns, vertices=int(seen.sum()), pixels=rows * columns)
    return header.encode("ascii") + points[seen].astype("<f4").tobytes() + _lists(seen).tobytes()


def _lists(seen: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Return one list for each pixel: its length as one byte, and the index of its vertex as four."""
    sizes = np.where(seen, 5, 1)
    starts = np.cumsum(sizes) - sizes
    octets = np.zeros(int(sizes.sum()), np.uint8)
    octets[starts[seen]] = 1
    indices = np.arange(int(seen.sum()), dtype="<i4").view(np.uint8).reshape(-1, 4)
    octets[starts[seen][:, None] + np.arange(1, 5)] = indices
    return octets


def write_conf(poses: Mapping[str, Pose]) -> bytes:
    """Write the poses of scans by the names of their files.

    A line holds the translation and the quaternion x y z w of the motion back, as in the Stanford
    repository.
    """
    from scipy.spatial.transform import Rotation  # noqa: PLC0415 # which requests need not import

    lines = []
    for name, pose in poses.items():
        numbers = [*pose.translation.tolist(), *Rotation.from_matrix(pose.rotation.T).as_quat().tolist()]
        lines.append(f"bmesh {name} {' '.join(map(repr, numbers))}\n")
    return "".join(lines).encode()
