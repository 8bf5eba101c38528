"""The colours of the page: one accent, quiet greys, and scales that stay legible on them."""

from collections.abc import Sequence

import numpy as np

from geometry.arrays import Scalars
from webui.glb.glb import Colours

ACCENT = (200, 68, 44)
"""What is selected."""
INK = (34, 48, 58)
QUIET = (150, 160, 168)
TRANSFER = (170, 178, 184)
BOARD = (128, 150, 132)
FIXTURE = (110, 116, 124)
COMPONENT = (204, 205, 206)
ROBOT = (186, 193, 199)
TOOL = (96, 112, 124)
"""What the flange carries."""
STAND = (206, 209, 211)
"""What stands around a robot."""
COLLIDING = (163, 32, 42)
"""Bodies that touch."""
NAMED = (
    (43, 108, 163), (47, 143, 126), (192, 138, 46), (125, 90, 155),
    (95, 125, 47), (155, 90, 110), (70, 130, 150), (140, 105, 80),
)  # fmt: skip
"""For functions, classes, templates: in their order, over again when there are more."""
_SCALE = np.array([(38, 70, 131), (42, 125, 142), (92, 166, 110), (226, 184, 84)], dtype=np.float64)


def of_names(names: Sequence[str]) -> dict[str, tuple[int, int, int]]:
    """Give each name a colour by its place."""
    return {name: NAMED[index % len(NAMED)] for index, name in enumerate(dict.fromkeys(names))}


def of_values(values: Scalars, low: float, high: float) -> Colours:
    """(n, 3) colours from dark and cold (low) to light and warm (high); none is like the accent."""
    share = np.clip((values - low) / max(high - low, 1e-9), 0.0, 1.0) * (len(_SCALE) - 1)
    stops = np.arange(len(_SCALE))
    return np.column_stack([np.interp(share, stops, channel) for channel in _SCALE.T]).astype(np.uint8)


def to_hex(colour: tuple[int, int, int]) -> str:
    """Write a colour as in ``#c8442c``."""
    return "#{:02x}{:02x}{:02x}".format(*colour)
