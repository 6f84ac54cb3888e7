"""Tapeline beside other programs that make curves of noisy points: ``python -m benchmarks.peers --help``.

The peers live in an environment of their own, which is no dependency of the project. Each runs in a
process of its own (:mod:`benchmarks.peers.worker`), gets the best of several settings chosen with
knowledge of the truth, and is measured as Tapeline is.
"""
