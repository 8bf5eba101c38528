"""What a browser does to plain colours, undone beforehand: so that they look as the legend beside them.

The viewer maps the light of a scene to the screen by three.js's ``ACESFilmicToneMapping`` at an exposure of 1. That is
Stephen Hill's fit of the ACES curves (BakingLab, ``ACES.hlsl``): two matrices around a rational function per channel.
"""

import numpy as np

from geometry.arrays import Scalars
from webui.glb.glb import Colours, light_of

_EXPOSURE = 1.0 / 0.6
_INPUT = np.array([[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]])
_OUTPUT = np.array([[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]])
_A, _B, _C, _D, _E = 0.0245786, 0.000090537, 0.983729, 0.4329510, 0.238081
"""Of ``(v (v + a) - b) / (v (c v + d) + e)``."""


def on_screen(colours: Colours) -> Colours:
    """(n, 3) what is seen of (n, 3) plain colours."""
    v = _EXPOSURE * light_of(colours) @ _INPUT.T
    fitted = (v * (v + _A) - _B) / (v * (_C * v + _D) + _E)
    return _screen(fitted @ _OUTPUT.T)


def as_seen(colours: Colours) -> Colours:
    """(n, 3) plain colours that are seen as (n, 3) colours; as near as can be where a screen shows no such colour."""
    y = np.clip(light_of(colours) @ np.linalg.inv(_OUTPUT).T, 0.0, 1.0)
    half, square = y * _D - _A, y * _C - 1.0  # square v^2 + half v + (y e + b) = 0
    v = (-half - np.sqrt(half**2 - 4 * square * (y * _E + _B))) / (2 * square)
    return _screen(v @ np.linalg.inv(_INPUT).T / _EXPOSURE)


def _screen(light: Scalars) -> Colours:
    """Back from light (IEC 61966-2-1)."""
    light = np.clip(light, 0.0, 1.0)
    screen = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    return np.round(255 * screen).astype(np.uint8)
