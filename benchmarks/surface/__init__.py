"""Scans to closed surfaces, beside Open3D and trimesh: ``python -m benchmarks.surface``.

Workers of Open3D's environment import this package: nothing here may import the core.
"""
