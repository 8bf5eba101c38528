"""What OpenCASCADE does to a STEP file, in a process of its own: imports nothing that takes time."""

import sys

TOL_LINEAR_MM = 0.02
"""Sag of a chord; the angle bounds the number of chords of small arcs."""

TOL_ANGULAR_RAD = 0.8


def triangulate(data: bytes) -> bytes:
    """Triangulate the bytes of a STEP file into those of a GLB; empty where it holds nothing that can be."""
    sys.modules["trimesh"] = None  # pyright: ignore[reportArgumentType]  # 0.6 s for an extension that is not used
    import cascadio

    return cascadio.load(data, tol_linear=TOL_LINEAR_MM, tol_angular=TOL_ANGULAR_RAD, use_parallel=False)
