"""Write the library's free-form part, a scan of a hood: `python tools/write_sample_parts.py`.

A shell over 320 x 220 mm with a scoop, its outline a rounded rectangle, as 12,000 points with 0.05 mm of noise.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

_FILE = Path(__file__).parents[1] / "boards" / "part" / "library" / "hood.ply"
_COUNT, _NOISE_MM, _SEED = 12_000, 0.05, 8
_SIZE_MM = np.array([320.0, 220.0])

Array = NDArray[np.float64]


def height(x: Array, y: Array) -> Array:
    """Of the shell above its lowest corner."""
    crown = 55.0 * (1.0 - ((x - 140.0) / 230.0) ** 2) * (1.0 - 0.7 * ((y - 105.0) / 150.0) ** 2)
    return crown + 16.0 * np.exp(-(((x - 225.0) / 48.0) ** 2) - ((y - 85.0) / 30.0) ** 2)


def points() -> Array:
    """Points about evenly over the surface."""
    rng = np.random.default_rng(_SEED)
    x, y = rng.uniform((0, 0), _SIZE_MM, (4 * _COUNT, 2)).T
    u, v = 2 * x / _SIZE_MM[0] - 1, 2 * y / _SIZE_MM[1] - 1
    step = 1e-3
    slopes = (height(x + step, y) - height(x, y)) / step, (height(x, y + step) - height(x, y)) / step
    area = np.sqrt(1.0 + slopes[0] ** 2 + slopes[1] ** 2)
    keep = (u**6 + v**6 < 1.0) & (rng.uniform(0, area.max(), len(x)) < area)
    x, y = x[keep][:_COUNT], y[keep][:_COUNT]
    return np.column_stack([x, y, height(x, y)]) + rng.normal(0, _NOISE_MM, (len(x), 3))


def main() -> None:
    """Write the points as a binary PLY without faces."""
    found = points()
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(found)}\n"
    head += "".join(f"property float {axis}\n" for axis in "xyz") + "end_header\n"
    _FILE.write_bytes(head.encode() + found.astype("<f4").tobytes())
    print(f"{_FILE.name}: {len(found)} points")


if __name__ == "__main__":
    main()
