"""Decks of rays: they measure the jet that they stand for."""

import numpy as np
import pytest
from small_sprays import NOZZLES, one_jet

from cleaning.jet.jet_coordinates import RAYS, ray_samples_of


def jet_named(name):
    return one_jet(NOZZLES[name], use="dry" if name == "knife" else "wash")


@pytest.mark.parametrize("name", NOZZLES)
def test_a_deck_carries_the_flow(name):
    jet = jet_named(name)
    deck = ray_samples_of(jet.form)
    assert (deck.strength * deck.spread).mean() * jet.form.scale == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("name", NOZZLES)
def test_so_does_any_run_of_it(name):
    jet = jet_named(name)
    deck = ray_samples_of(jet.form)
    shares = (deck.strength * deck.spread * jet.form.scale).reshape(-1, 192).mean(axis=1)
    assert np.abs(shares - 1).max() < 0.15
    assert shares.std() < 0.05


@pytest.mark.parametrize("name", ["ring", "cone"])
def test_a_deck_measures_the_outer_cone(name):
    jet = jet_named(name)
    deck = ray_samples_of(jet.form)
    whole = 2 * np.pi * (1 - np.cos(jet.half_angle + 2 * jet.sigma))
    assert (deck.inside * deck.spread).mean() == pytest.approx(whole, rel=2e-3)


@pytest.mark.parametrize("name", NOZZLES)
def test_no_ray_stands_for_much_more_flow_than_others(name):
    jet = jet_named(name)
    deck = ray_samples_of(jet.form)
    assert (deck.strength * deck.spread * jet.form.scale).max() < 3.0


def test_a_deck_is_the_same_each_time():
    one, other = ray_samples_of(jet_named("lopsided").form), ray_samples_of(jet_named("lopsided").form)
    assert len(one.directions) == RAYS
    assert np.array_equal(one.directions, other.directions)
    assert np.array_equal(one.spread, other.spread)


@pytest.mark.parametrize("name", NOZZLES)
def test_rays_are_unit_vectors_that_leave_forwards(name):
    deck = ray_samples_of(jet_named(name).form)
    np.testing.assert_allclose(np.linalg.norm(deck.directions, axis=1), 1.0)
    assert np.all(deck.directions[:, 2] > 0)
    half = NOZZLES[name].width_mm / 2 if name == "knife" else 0.0
    assert np.abs(deck.starts).max() <= half
