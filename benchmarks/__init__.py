"""Benchmarks: accuracy against the oracle, time against the point count, HTTP against the call in process."""
