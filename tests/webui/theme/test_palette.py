"""Text can be read on all grounds, light and dark: WCAG 2.2 asks for a contrast of 4.5 : 1."""

import re
from pathlib import Path

import pytest

import webui
from webui.theme.palette import (
    NAMED,
    QUIET,
    contrast,
    css_colour,
    grounds_of_text,
    ink_on,
    shades_of_text,
    to_hex,
)

WEBUI = Path(webui.__file__).parent


def test_contrast_is_that_of_wcag():
    assert contrast((0, 0, 0), (255, 255, 255)) == pytest.approx(21.0)
    assert contrast((119, 119, 119), (255, 255, 255)) == pytest.approx(4.48, abs=0.01)
    assert contrast((10, 90, 30), (10, 90, 30)) == 1.0


@pytest.mark.parametrize("dark", [False, True])
def test_every_text_has_contrast_on_every_ground(dark):
    for name, shade in shades_of_text(dark=dark).items():
        for ground, tint in grounds_of_text(dark=dark).items():
            assert contrast(shade, tint) >= 4.5, f"{name} on {ground}, {'dark' if dark else 'light'}"


def test_names_on_coloured_bands_have_contrast():
    inks = {"#fff": (255, 255, 255), "#000": (0, 0, 0)}
    for tint in (*NAMED, QUIET):
        assert contrast(inks[ink_on(tint)], tint) >= 4.5


def test_html_names_its_colours_so_that_they_follow_light_and_dark():
    assert css_colour(QUIET) == f"var(--wb-quiet,{to_hex(QUIET)})"
    assert css_colour((1, 2, 3)) == "#010203"
    for file in (*WEBUI.glob("cards/*.py"), *WEBUI.glob("panels/*/*.py")):
        assert not re.search(r"(color|background):#[0-9a-f]{3}", file.read_text()), file
