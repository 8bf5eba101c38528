"""Spacings of parallel passes: every valley of the ripple is found, and films add up."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.coverage.spacing import find_spacings, overlap

ACROSS = np.linspace(-40.0, 40.0, 4001)
PARABOLA = np.clip(1600 - ACROSS**2, 0, None) ** 1.5 / 6
"""One pass of Jiangsu 2010 at 1 mm/s."""


def test_every_valley_of_the_printed_gun() -> None:
    found = find_spacings(ACROSS, PARABOLA, 20.0)
    assert [each.spacing for each in found] == pytest.approx([48.665, 29.70, 21.54], abs=0.02)
    assert [100 * each.ripple for each in found] == pytest.approx([3.92, 1.06, 0.46], abs=0.02)
    assert [each.middle / 40 for each in found] == pytest.approx([256.604, 422.5, 583.2], abs=0.5)


def test_between_two_valleys_is_a_hill() -> None:
    assert overlap(ACROSS, PARABOLA, 40.0).ripple == pytest.approx(0.13, abs=0.005)


def test_triangles_are_even_at_their_half_width() -> None:
    found = find_spacings(ACROSS, np.maximum(1.0 - np.abs(ACROSS) / 40.0, 0.0), 35.0)
    assert [each.spacing for each in found] == pytest.approx([40.0], abs=1e-3)
    assert found[0].ripple < 1e-3


def test_passes_that_leave_nothing_have_no_spacing() -> None:
    assert find_spacings(ACROSS, 0 * ACROSS, 10.0) == ()


@settings(max_examples=25)
@given(spacing=st.floats(5.0, 79.0), shift=st.floats(-30.0, 30.0), size=st.floats(0.1, 10.0))
def test_the_film_keeps_its_volume_wherever_the_passes_lie(spacing, shift, size) -> None:
    here, there = overlap(ACROSS, PARABOLA, spacing), overlap(size * (ACROSS + shift), PARABOLA, size * spacing)
    assert here.low <= here.mean <= here.high
    assert here.mean * spacing == pytest.approx(502_654.8, rel=1e-5)
    assert (there.low, there.high) == pytest.approx((here.low, here.high), rel=2e-3)
