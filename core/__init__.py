"""Tapeline's geometry: noisy point sets in, piecewise-linear curves out.

Arrays in, frozen dataclasses out; nothing here knows of the web or of files.
"""
