"""Standoffs as unknowns: passes too far apart are made even by raising the nozzle, within the band alone."""

from importlib import import_module
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import csr_array
from small_sprays import GUN

import robotcell
from cleaning.exposure.segment_rates import Segments, segment_rates
from cleaning.jet.jet import form_of
from cleaning.parameters.load import load_parameters
from geometry.coverage.dwell import Unknowns, even_film
from rulesengine.levelling.segments import knots_of

BENCHMARKS = Path(robotcell.__file__).parents[1] / "benchmarks"
FORM = form_of(GUN, GUN.flow_lpm, load_parameters("default").spray)
FILM_UM, PASSES, SEGMENTS, SEGMENT_MM, STANDOFF_MM = 40.0, 3, 12, 15.0, 100.0


@pytest.fixture
def standoffs(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    return import_module("film_standoffs")


def plate(spacing):
    """Passes along x above a plate, and its cells between the outer passes, off the ends."""
    x = (np.arange(SEGMENTS + 1) - SEGMENTS / 2) * SEGMENT_MM
    tcp = np.array([[[a, y, 100.0], [b, y, 100.0]] for y in spacing * (np.arange(PASSES) - 1.0)
                    for a, b in pairwise(x)])  # fmt: skip
    down, aside = np.array([0.0, 0.0, -1.0]), np.array([0.0, 1.0, 0.0])
    segments = Segments(tcp, np.broadcast_to(down, tcp.shape).copy(), np.broadcast_to(aside, tcp.shape).copy())
    grid = np.meshgrid(np.arange(-40.0, 41.0, 10.0), np.arange(-spacing, spacing + 0.1, 1.0))
    cells = np.column_stack([grid[0].ravel(), grid[1].ravel(), np.zeros(grid[0].size)])
    return segments, cells


def setting(spacing):
    segments, cells = plate(spacing)
    weights, pairs = knots_of([SEGMENTS] * PASSES, 3)
    seconds = csr_array(weights.multiply(segments.lengths[:, None]))
    size = weights.shape[1]
    unknowns = Unknowns(
        np.asarray(seconds.sum(axis=0)).ravel(), np.full(size, 1 / 700), np.full(size, 1 / 20), pairs,
        np.ones(len(pairs)), np.full(len(pairs), 1e-3),
    )  # fmt: skip
    up = np.tile([0.0, 0.0, 1.0], (len(cells), 1))
    return segments, (seconds, unknowns), np.full(len(cells), FILM_UM), lambda way: segment_rates(FORM, way, cells, up)


def fitted(standoffs, spacing, band):
    segments, paces, film, lay = setting(spacing)
    return standoffs.fit_standoffs(lay, (segments, [SEGMENTS] * PASSES, STANDOFF_MM), paces, film, band)


@pytest.mark.slow
def test_passes_too_far_apart_are_raised_until_they_overlap(standoffs) -> None:
    """At 51.2 mm a parabola of radius 40 mm leaves 7 %, at the even spacing 3.92 %: 5 % more standoff is that again."""
    segments, (seconds, unknowns), film, lay = setting(51.2)
    fit = fitted(standoffs, 51.2, 8.0)
    assert fit.before > 0.05
    assert fit.deviation < 0.042
    assert 2.0 < fit.shifts_mm.mean() < 8.0
    again = even_film(csr_array(lay(standoffs.moved(segments, fit.shifts_mm)) @ seconds), film, unknowns)
    assert again.value <= fit.deviation + 1e-6
    assert again.gap < 1e-4


def test_the_nozzle_stays_in_the_band_and_passes_stay_whole(standoffs) -> None:
    fit = fitted(standoffs, 51.2, 1.5)
    assert np.abs(fit.shifts_mm).max() <= 1.5 + 1e-9
    assert fit.deviation < fit.before
    ends = fit.segments.tcp.reshape(PASSES, SEGMENTS, 2, 3)
    assert ends[:, 1:, 0] == pytest.approx(ends[:, :-1, 1], abs=1e-9)


def test_without_a_band_nothing_moves(standoffs) -> None:
    fit = fitted(standoffs, 48.66, 0.0)
    assert fit.deviation == pytest.approx(fit.before, abs=1e-4)
    assert (fit.shifts_mm == 0.0).all()
