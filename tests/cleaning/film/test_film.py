import math
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from jet_references import footprint
from small_sprays import NOZZLES, PARAMETERS, downward, one_jet

from cleaning.film.film import farthest, film_around, film_momentum, rim_of

FILM = PARAMETERS.film
SLOPE = math.tan(math.radians(30.0))


@cache
def jet_named(name):
    return one_jet(NOZZLES[name])


def rim(name="ring", half_deg=None):
    jet = jet_named(name)
    if half_deg is not None:
        jet = replace(jet, half_angles=np.full(len(jet.azimuths), np.radians(half_deg)))
    return rim_of(jet, FILM)


class Spot(NamedTuple):
    """A direction on the board, seen from the pole of a jet that leans towards +x and is turned about its own axis."""

    turn_deg: float
    turn: np.ndarray
    standoff_mm: float
    facing: float


def spot(turn_deg, tilt_deg=0.0, height_mm=50.0, azimuth_deg=0.0):
    about, facing = np.radians(azimuth_deg), np.cos(np.radians(tilt_deg))
    spin = np.array([[np.cos(about), -np.sin(about), 0], [np.sin(about), np.cos(about), 0], [0, 0, 1]])
    return Spot(turn_deg, downward(tilt_deg) @ spin, height_mm / facing, facing)


def around(known, at, turns_deg, away_mm):
    """(3, n) distance to the rim, the film's share of the flow per width, and its momentum, all at distances."""
    turns, away = np.radians(turns_deg), np.broadcast_to(np.asarray(away_mm, dtype=float), np.shape(turns_deg)).copy()
    far, share = np.empty(len(turns)), np.empty(len(turns))
    ways = away * np.cos(turns), away * np.sin(turns)
    film_around(known, np.ascontiguousarray(at.turn), (at.standoff_mm, at.facing), ways, (far, share))
    momenta = [film_momentum(known, *each) for each in zip(far, share, away, strict=True)]
    return np.array([far, share, momenta])


def rim_of_spot(known, at):
    return around(known, at, [at.turn_deg], 1.0)[0, 0]


def momentum(at, away_mm, known=None):
    return around(rim() if known is None else known, at, [at.turn_deg], away_mm)[2, 0]


def seen(known, turns_deg, *how):
    """Distance to the rim, and what leaves it outwards and inwards, each way."""
    at = spot(0.0, *how)
    far = around(known, at, turns_deg, 1.0)[0]
    return far, around(known, at, turns_deg, far)[2], -around(known, at, turns_deg, 0.4 * far)[2] / 0.4


@pytest.mark.slow
def test_the_reference_film():
    far = rim_of_spot(rim(), spot(0.0))
    assert far == pytest.approx(50.0 * SLOPE)
    assert momentum(spot(0.0), far) == pytest.approx(1.641, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("turn_deg", [0.0, 33.0, 180.0, 271.0])
def test_an_upright_ring_follows_the_plain_law(turn_deg):
    jet, at = jet_named("ring"), spot(turn_deg)
    far = 50.0 * SLOPE
    whole = FILM.retention * jet.density_kg_m3 * jet.speed_m_s * jet.flow_m3_s / (2e-3 * np.pi * far)
    for away in (far, far + 3.0, 2.0 * far, 3.0 * far):
        assert momentum(at, away) == pytest.approx(
            0.75 * whole * far / away * math.exp(-(away - far) / FILM.decay_mm), rel=1e-9
        )
    for away in (0.01, 3.0, 0.8 * far):
        assert momentum(at, away) == pytest.approx(-0.25 * whole * away / far, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(("half_deg", "share"), [(30.0, 0.75), (40.0, 0.821)])
def test_the_sheet_divides_as_in_the_books(half_deg, share):
    known = rim(half_deg=half_deg)
    _, outward, inward = seen(known, [0.0])
    assert outward / (outward + inward) == pytest.approx(share, abs=5e-4)


@pytest.mark.slow
@settings(max_examples=25)
@given(
    nozzle=st.sampled_from(["ring", "lopsided", "cone", "fan"]),
    tilt=st.floats(0.0, 45.0),
    height=st.floats(15.0, 150.0),
    azimuth=st.floats(0.0, 360.0),
)
def test_both_films_together_carry_all_that_is_sprayed(nozzle, tilt, height, azimuth):
    known = rim(nozzle)
    far, out, back = seen(known, np.arange(0.0, 360.0, 0.25), tilt, height, azimuth)
    carried = 2 * np.pi * np.mean((out + back) * 1e-3 * far)
    assert carried == pytest.approx(known.momentum_n, rel=5e-3)


@pytest.mark.slow
@settings(max_examples=25)
@given(half=st.floats(10.0, 40.0), tilt=st.floats(0.0, 44.0), height=st.floats(10.0, 150.0), first=st.floats(0.0, 40.0))
def test_the_rim_of_a_cone_is_its_ellipse(half, tilt, height, first):
    known = rim(half_deg=half)
    turns = np.arange(first, 360.0, 40.0)
    far, *_ = seen(known, turns, tilt, height)
    ellipse = footprint(np.radians(half), np.radians(tilt), height)
    x = height * np.tan(np.radians(tilt)) + far * np.cos(np.radians(turns)) - ellipse.centre
    y = far * np.sin(np.radians(turns))
    np.testing.assert_allclose((x / ellipse.semi_major) ** 2 + (y / ellipse.semi_minor) ** 2, 1.0, rtol=1e-6)
    at = spot(0.0, tilt, height)
    assert far.max() <= farthest(known, at.standoff_mm, at.facing) * (1 + 1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("nozzle", ["fan", "knife"])
@pytest.mark.parametrize("tilt", [0.0, 20.0])
def test_the_rim_of_a_rectangle_is_no_farther_than_its_corners(nozzle, tilt):
    known = rim(nozzle)
    far, *_ = seen(known, range(0, 360, 5), tilt, 50.0, 40.0)
    at = spot(0.0, tilt)
    assert far.max() <= farthest(known, at.standoff_mm, at.facing)
    assert far.min() > 0.0


def test_an_upright_fan_ends_at_its_sides():
    known = rim("fan")
    assert rim_of_spot(known, spot(0.0)) == pytest.approx(50.0 * math.tan(math.radians(40.0)))
    assert rim_of_spot(known, spot(90.0)) == pytest.approx(50.0 * math.tan(math.radians(3.0)))


def test_a_curtain_is_as_long_as_its_slot_and_more():
    far = rim_of_spot(rim("knife"), spot(0.0))
    assert far == pytest.approx(40.0 + 50.0 * math.tan(math.radians(5.0)))


def test_where_the_spray_is_open_there_is_no_film():
    at = spot(0.0, tilt_deg=65.0)
    assert rim_of_spot(rim(), at) == math.inf
    assert momentum(at, 40.0) == 0.0
    assert farthest(rim(), at.standoff_mm, at.facing) == math.inf
    assert momentum(spot(180.0, tilt_deg=65.0), 150.0) > 0.0


def test_a_leaning_jet_drives_its_film_forward():
    _, out, back = seen(rim(), [0.0, 180.0], 25.0)
    shares = out / (out + back)
    assert shares[0] == pytest.approx((1 + math.sin(math.radians(55.0))) / 2, rel=1e-6)
    assert shares[1] == pytest.approx((1 + math.sin(math.radians(5.0))) / 2, rel=1e-6)


def test_more_flow_where_a_measured_ring_is_wider_and_broader():
    known = rim("lopsided")
    far, out, back = seen(known, range(360))
    flows = 2e-3 * np.pi * far * (out + back) / known.momentum_n
    assert np.mean(flows) == pytest.approx(1.0, abs=5e-3)
    assert np.ptp(flows) > 0.2


@pytest.mark.parametrize("name", ["ring", "lopsided", "cone", "fan"])
def test_the_film_turns_over_the_breadth_of_the_wave_front(name):
    known, at = rim(name), spot(20.0, 15.0)
    far = rim_of_spot(known, at)
    places = far * np.concatenate([np.linspace(0.3, 1.0, 400), np.linspace(1.0, 1.2, 100)])
    found = around(known, at, np.full(len(places), at.turn_deg), places)[2]
    assert np.abs(np.diff(found)).max() < 0.03 * np.ptp(found)
    assert found[0] < 0.0 < found[-1]
    assert found.max() == pytest.approx(momentum(at, far, known))
