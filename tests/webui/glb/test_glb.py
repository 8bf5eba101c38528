"""Plain colours are seen as they are asked for."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from webui.glb import glb
from webui.glb.glb import as_seen
from webui.theme.palette import of_values


def on_screen(colours):
    """What the viewer's tone mapping makes of plain colours."""
    v = glb._EXPOSURE * glb.light_of(colours) @ glb._INPUT.T
    light = np.clip((v * (v + glb._A) - glb._B) / (v * (glb._C * v + glb._D) + glb._E) @ glb._OUTPUT.T, 0.0, 1.0)
    screen = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    return np.round(255 * screen).astype(np.uint8)


def test_what_a_browser_showed():
    """Read off pictures of plain triangles in chromium."""
    asked = np.array([(38, 70, 131), (42, 125, 142), (92, 166, 110), (226, 184, 84), (222, 150, 48)], np.uint8)
    seen = np.array([(4, 60, 139), (14, 135, 154), (110, 180, 125), (219, 195, 110), (220, 169, 64)])
    np.testing.assert_allclose(on_screen(asked).astype(int), seen, atol=2)


def test_every_colour_of_the_scale_is_seen_as_it_is():
    scale = of_values(np.linspace(0, 1, 101), 0.0, 1.0)
    np.testing.assert_allclose(on_screen(as_seen(scale)).astype(int), scale.astype(int), atol=2)


@settings(max_examples=50)
@given(st.lists(st.tuples(*[st.integers(0, 255)] * 3), min_size=1, max_size=20))
def test_no_colour_breaks_it(colours):
    wanted = np.array(colours, np.uint8)
    for found in (as_seen(wanted), on_screen(wanted)):
        assert found.shape == wanted.shape
        assert found.dtype == np.uint8
    grey = np.repeat(wanted[:, :1], 3, axis=1)
    back = on_screen(as_seen(grey)).astype(int)
    kept = grey[:, 0] < 200  # beyond, a screen shows no such light
    np.testing.assert_allclose(back[kept], grey[kept].astype(int), atol=3)
