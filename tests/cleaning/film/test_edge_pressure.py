import math
from dataclasses import replace
from functools import cache, partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from jet_references import gas_speed_at, stress_at
from small_sprays import NOZZLES, PARAMETERS, downward, one_jet, samples_of, stage_of

from cleaning.film.edge_pressure import edge_pressures
from cleaning.gap.edge_segments import Edges

FILM = PARAMETERS.film
RADIUS_MM = 50.0 * math.tan(math.radians(30.0))
UP = np.array([[0.0, 0.0, 1.0]])
OUTWARD = np.array([[0, -1, 0], [0, -1, 0], [1, 0, 0], [1, 0, 0], [0, 1, 0], [0, 1, 0], [-1, 0, 0], [-1, 0, 0]])
MIDDLES = np.array([[-1, -2, 0], [1, -2, 0], [2, -1, 0], [2, 1, 0], [1, 2, 0], [-1, 2, 0], [-2, 1, 0], [-2, -1, 0]])


@cache
def jet_named(name, use="wash", pressure_bar=3.5):
    return one_jet(NOZZLES[name], use, pressure_bar)


def turned(degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def edges_of(places, *, turn_deg=0.0, height=1.0, facing=1.0, sheltered=np.inf):
    """Square parts of 4 mm with their middles at (x, y)."""
    places = np.atleast_2d(np.array(places, dtype=float))
    spin, n = turned(turn_deg), len(places)
    middles = MIDDLES @ spin.T + np.column_stack([places, np.zeros(n)])[:, None, :]
    outward = np.tile(OUTWARD @ spin.T, (n, 1, 1))
    shelter = np.broadcast_to(np.asarray(sheltered, dtype=float), (n, 8)).copy()
    return Edges(np.arange(n), middles, outward, np.full(n, height), shelter, np.full(n, facing))


def felt(edges, tcp=(0.0, 0.0, 50.0), axes=None, *, film=FILM, jet=None):
    """(rows, 8) for a single pose."""
    jet = jet_named("ring") if jet is None else jet
    found = edge_pressures(stage_of(samples_of([tcp], axes)), jet, edges, film)
    return np.array([each.pressure_pa[0] if len(each.sample) else np.full(8, np.nan) for each in found])


def struck(edges, tcp=(0.0, 0.0, 50.0), axes=None, jet=None):
    axes = downward() if axes is None else axes
    jet = jet_named("ring") if jet is None else jet
    normals = np.broadcast_to(UP * edges.facing[0], (edges.middles.size // 3, 3))
    found = stress_at(jet, np.array([tcp]), axes[None], edges.middles.reshape(-1, 3), normals)
    return found.reshape(-1, 8)


@pytest.mark.slow
def test_the_film_at_the_wave_front_presses_with_820_pa():
    # The middle of segment 6 lies on the ring and faces the pole.
    edges = edges_of([RADIUS_MM * 1.0000001 + 2.0, -1.0])
    film_term = (felt(edges) - struck(edges))[0, 6]
    assert film_term == pytest.approx(820.0, rel=2e-3)


def test_what_comes_aslant_presses_with_the_square_of_the_cosine():
    still = edges_of([70.0, -1.0])
    head_on = felt(still)[0, 6]
    aslant = replace(still, outward=still.outward @ turned(60.0).T)
    assert felt(aslant)[0, 6] == pytest.approx(0.25 * head_on)
    behind = replace(still, outward=still.outward @ turned(180.0).T)
    assert felt(behind)[0, 6] == pytest.approx(-FILM.lee * head_on)


@pytest.mark.parametrize("turn_deg", [0.0, 20.0, 45.0])
def test_the_windward_edges_are_pressed_and_the_lee_is_sucked(turn_deg):
    pressure = felt(edges_of([60.0, 3.0], turn_deg=turn_deg))[0]
    away = np.sum(edges_of([60.0, 3.0], turn_deg=turn_deg).outward[0] * [60.0, 3.0, 0.0], axis=1)
    assert np.all(pressure[away < -1.0] > 0.0)
    assert np.all(pressure[away > 1.0] < 0.0)


def test_within_the_ring_the_film_runs_to_the_pole():
    edges = edges_of([14.0, -1.0])
    pressure = felt(edges)[0] - struck(edges)[0]
    assert pressure[2] > 0.0 > pressure[6]


def test_beyond_three_radii_nothing_happens():
    assert (
        len(edge_pressures(stage_of(samples_of([[0, 0, 50]])), jet_named("ring"), edges_of([90, 0]), FILM)[0].sample)
        == 0
    )
    near = felt(edges_of([3 * RADIUS_MM + 1.0, 0.0]))[0]
    assert near[6] > 0.0
    assert near[2] == 0.0


def test_only_jets_on_the_own_side_count():
    top, bottom = edges_of([30.0, 0.0]), edges_of([30.0, 0.0], facing=-1.0)
    assert np.isnan(felt(bottom)).all()
    assert np.isnan(felt(top, (0.0, 0.0, -50.0), -downward())).all()
    mirror = np.diag([1.0, 1.0, -1.0])
    from_below = mirror @ downward(20.0, 30.0) @ np.diag([1.0, -1.0, 1.0])
    from_above = downward(20.0, 30.0)
    np.testing.assert_allclose(
        felt(bottom, (0.0, 0.0, -50.0), from_below), felt(top, (0.0, 0.0, 50.0), from_above), rtol=1e-12
    )


@settings(max_examples=25)
@given(
    x=st.floats(-60.0, 60.0),
    y=st.floats(-60.0, 60.0),
    tilt=st.floats(0.0, 40.0),
    lean=st.floats(0.0, 360.0),
    name=st.sampled_from(["ring", "lopsided", "cone", "fan"]),
)
def test_a_quarter_turn_of_the_board_moves_nothing_but_the_board(x, y, tilt, lean, name):
    jet, axes = jet_named(name), downward(tilt, lean)
    still = felt(edges_of([x, y]), axes=axes, jet=jet)
    quarter = turned(90.0)
    place = quarter[:2, :2] @ [x, y]
    together = felt(edges_of(place, turn_deg=90.0), axes=quarter @ axes, jet=jet)
    np.testing.assert_allclose(together, still, rtol=1e-6, atol=1e-6 * max(1.0, np.nanmax(np.abs(still), initial=0.0)))
    # A square part that is turned by itself has the same edges under other numbers.
    np.testing.assert_allclose(felt(edges_of([x, y], turn_deg=90.0), axes=axes, jet=jet), np.roll(still, -2), atol=1e-6)


@settings(max_examples=15)
@given(x=st.floats(-60.0, 60.0), y=st.floats(-60.0, 60.0), tilt=st.floats(0.0, 40.0), height=st.floats(0.0, 8.0))
def test_twice_the_pressure_presses_twice_as_hard(x, y, tilt, height):
    edges, axes = edges_of([x, y], height=height), downward(tilt)
    once = felt(edges, axes=axes)
    twice = felt(edges, axes=axes, jet=jet_named("ring", "wash", 7.0))
    np.testing.assert_allclose(twice, 2.0 * once, rtol=1e-9, atol=1e-9)


@settings(max_examples=25)
@given(
    x=st.floats(-60.0, 60.0),
    y=st.floats(-60.0, 60.0),
    tilt=st.floats(0.0, 40.0),
    blocked=st.lists(st.booleans(), min_size=8, max_size=8),
)
def test_neighbours_never_raise_what_presses(x, y, tilt, blocked):
    axes = downward(tilt)
    free = felt(edges_of([x, y]), axes=axes)
    shelter = felt(edges_of([x, y], sheltered=np.where(blocked, 4.9, 5.1)), axes=axes)
    assert np.array_equal(np.isnan(free), np.isnan(shelter))
    assert np.all(np.isnan(free) | (shelter <= free))
    assert np.array_equal(shelter[0, ~np.array(blocked)], free[0, ~np.array(blocked)], equal_nan=True)


def test_an_upstream_neighbour_takes_its_share():
    alone = felt(edges_of([70.0, 0.0]))[0]
    all_around = felt(edges_of([70.0, 0.0], sheltered=3.0))[0]
    assert all_around[[6, 7]] == pytest.approx(FILM.shelter * alone[[6, 7]])
    assert all_around[[2, 3]] == pytest.approx(alone[[2, 3]])


def test_no_pressure_is_above_the_stagnation_pressure():
    jet = jet_named("ring")
    shallow = FILM.model_copy(update={"puddle_mm": 1e-4})
    assert felt(edges_of([RADIUS_MM + 2.0, 0.0]), film=shallow).max() == 0.5 * jet.density_kg_m3 * jet.speed_m_s**2


def test_a_tall_part_keeps_the_jet_off_what_is_behind_it():
    # The ring meets the board beyond the part, whose rear edge is on the ring.
    place = [RADIUS_MM - 2.0, 0.0]
    flat, tall = edges_of(place, height=0.0), edges_of(place, height=5.0)
    assert (felt(flat) - felt(tall))[0, [2, 3]] == pytest.approx(struck(flat)[0, [2, 3]])
    before = edges_of([RADIUS_MM + 2.0, 0.0], height=5.0)
    low = edges_of([RADIUS_MM + 2.0, 0.0], height=0.0)
    assert felt(before)[0, [6, 7]] == pytest.approx(felt(low)[0, [6, 7]])


def test_under_the_pole_itself_there_is_no_direction():
    edges = edges_of([2.0, -1.0])
    for name, use in (("ring", "wash"), ("fan", "wash"), ("knife", "dry")):
        jet = jet_named(name, use)
        pressure = felt(edges, (0.0, 0.0, 50.0), jet=jet)[0]
        assert np.isfinite(pressure).all()
        assert pressure[6] == pytest.approx(struck(edges, jet=jet)[0, 6])


@pytest.mark.parametrize("name", ["ring", "lopsided", "cone", "fan", "knife"])
def test_without_a_film_only_the_jet_itself_presses(name):
    random = np.random.default_rng(8)
    jet, film = jet_named(name), FILM.model_copy(update={"retention": 0.0})
    places = random.uniform(-50.0, 50.0, (300, 2))
    axes = downward(25.0, 40.0)
    pressure, stress = (
        how(edges_of(places, height=0.0), axes=axes, jet=jet) for how in (partial(felt, film=film), struck)
    )
    reached = ~np.isnan(pressure) & (pressure != 0.0)
    assert reached.sum() > 20
    np.testing.assert_allclose(pressure[reached], stress[reached], rtol=1e-9)
    if name != "knife":  # a ring's whole flank lies within three radii
        np.testing.assert_allclose(np.nan_to_num(pressure), stress, rtol=1e-9, atol=1e-3 * stress.max())


def test_samples_are_judged_one_by_one():
    random = np.random.default_rng(5)
    tcp = np.column_stack([random.uniform(-150, 150, (60, 2)), random.uniform(20, 80, 60)])
    axes = np.array([downward(tilt, turn) for tilt, turn in random.uniform(0, [40, 360], (60, 2))])
    edges = edges_of([[0.0, 0.0], [40.0, -10.0]])
    found = edge_pressures(stage_of(samples_of(tcp, axes)), jet_named("ring"), edges, FILM)
    for row, each in enumerate(found):
        assert 0 < len(each.sample) < 60
        assert np.all(np.diff(each.sample) > 0)
        for at in range(60):
            alone = felt(edges, tcp[at], axes[at])[row]
            if at in each.sample:
                np.testing.assert_array_equal(each.pressure_pa[each.sample == at][0], alone)
            else:
                assert np.isnan(alone).all()


def test_there_is_one_answer_for_each_row():
    stage = stage_of(samples_of([[0.0, 0.0, 50.0]]))
    edges = edges_of(np.empty((0, 2)))
    assert edge_pressures(stage, jet_named("ring"), edges, FILM) == []


def test_a_curtain_of_air_blows_with_its_stagnation_pressure():
    # The slot lies along x; the part stands beside the line that it strikes and faces it with its front edge.
    jet = jet_named("knife", "dry")
    edges = edges_of([0.0, 5.0])
    pressure = felt(edges, (0.0, 0.0, 20.0), jet=jet)[0]
    speed = gas_speed_at(jet, np.array([20.0 + 3.0]))[0]
    assert pressure[[0, 1]] == pytest.approx(0.5 * jet.density_kg_m3 * speed**2, rel=1e-6)
    assert np.all(pressure[[4, 5]] <= 0.0)
    assert (
        np.abs(felt(edges_of([0.0, 2.0]), (0.0, 0.0, 20.0), jet=jet)).max()
        <= 0.5 * jet.density_kg_m3 * jet.speed_m_s**2
    )


def test_air_from_a_cone_is_slower_farther_away():
    jet = jet_named("cone", "dry")
    near, far = (felt(edges_of([place, -1.0]), jet=jet)[0, 6] for place in (40.0, 60.0))
    assert near > far > 0.0
