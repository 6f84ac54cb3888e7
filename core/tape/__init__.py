"""The tape: the strip of triangles that the samples of a curve fill, and its skeleton (§4.3-4.5)."""
