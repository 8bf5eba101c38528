"""Joints squeeze residue into the gap; where they take much of it, it is bridged."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cleaning.gap.initial_fill import exchanges_needed, fill_share, is_plugged, open_share
from cleaning.parameters.load import load_parameters

PARAMETERS = load_parameters("default")
SOIL, GAP = PARAMETERS.soil, PARAMETERS.gap


@pytest.mark.parametrize(("coverage", "fill"), [(0.0, 0.0), (0.2, 0.1125), (0.4, 0.30), (0.5, 0.45), (0.6, 0.675)])
def test_fill_follows_from_coverage(coverage: float, fill: float) -> None:
    assert fill_share(SOIL, coverage) == pytest.approx(fill, rel=1e-12)


def test_wide_pads_bridge_the_gap() -> None:
    assert not is_plugged(GAP, fill_share(SOIL, 0.6))
    assert is_plugged(GAP, fill_share(SOIL, 0.66))
    assert fill_share(SOIL, 0.69) == 1.0
    assert fill_share(SOIL, 1.0) == 1.0


def test_venting_empties_the_gap() -> None:
    assert fill_share(SOIL, 0.5, 0.3) == pytest.approx(0.3 * fill_share(SOIL, 0.5))
    assert fill_share(SOIL, 0.5, 0.0) == 0.0


@settings(deadline=None, max_examples=100)
@given(coverage=st.floats(0, 1), more=st.floats(0, 1), factor=st.floats(0, 3))
def test_more_pad_never_means_less_residue(coverage: float, more: float, factor: float) -> None:
    larger = coverage + more * (1.0 - coverage)
    assert 0.0 <= fill_share(SOIL, coverage, factor) <= fill_share(SOIL, larger, factor) <= 1.0


def test_a_qfn_needs_its_liquid_renewed_about_eighteen_times() -> None:
    assert exchanges_needed(SOIL, GAP, 0.45) == pytest.approx(18.0)
    assert exchanges_needed(SOIL, GAP, 0.0) == 0.0


def test_a_plugged_gap_is_open_at_its_rim() -> None:
    assert open_share(GAP, 1.0) == pytest.approx(0.15)
    assert open_share(GAP.model_copy(update={"plugged": 1.0}), 1.0) > 0.0
    assert exchanges_needed(SOIL, GAP, 1.0) == exchanges_needed(SOIL, GAP, GAP.plugged)
