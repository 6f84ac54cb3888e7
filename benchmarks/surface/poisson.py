"""Open3D's Poisson reconstruction in a process of its own: ``python -m benchmarks.surface.poisson IN OUT``.

Runs in Open3D's environment, so nothing here may import the core.
"""

from __future__ import annotations

import resource
import sys
import time

import numpy as np

__all__ = ["DEPTH", "main"]

DEPTH = 8  # of the octree


def main(arguments: list[str]) -> None:
    """Read points and normals, write vertices, faces and seconds."""
    import open3d  # noqa: PLC0415 - only in the environment that has it

    source, target = arguments
    with np.load(source) as known:
        cloud = open3d.geometry.PointCloud()
        cloud.points = open3d.utility.Vector3dVector(known["points"])
        cloud.normals = open3d.utility.Vector3dVector(known["normals"])
    began, clock = _cpu(), time.monotonic()
    mesh, _ = open3d.geometry.TriangleMesh.create_from_point_cloud_poisson(cloud, depth=DEPTH, n_threads=1)
    seconds = np.array([_cpu() - began, time.monotonic() - clock])
    np.savez(
        target,
        vertices=np.asarray(mesh.vertices),
        faces=np.asarray(mesh.triangles, np.int64),
        seconds=seconds,
    )


def _cpu() -> float:
    """CPU seconds of this process, all its threads."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


if __name__ == "__main__":
    main(sys.argv[1:])
