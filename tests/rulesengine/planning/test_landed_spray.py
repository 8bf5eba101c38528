"""The share of the spray that lands on the board: strips of known width under a ring of known angle."""

import math

import numpy as np
import pytest
from shapely import box
from small_boards import board_of

from programs.plan import Dwell, Jet, SprayPass
from recipes.load import parse_recipe
from rulesengine.planning.spray_findings import find_spray_beside, landed_shares
from specs.source import Source

RECIPE = parse_recipe("recipe: strips\nextends: smt-aqueous\nnozzles: {ring60: {wavefront: null}}\n")
JET = Jet("clean", "ring60", "saponifier-15", 2.0, liquid=True)
MADE_BY = Source(0, "sweep")


def lane(y=0.0, height=60.0, x=(-100.0, 100.0), jet=JET):
    tcp = np.array([[each, y, height] for each in x])
    ways = np.broadcast_to([0.0, 0.0, -1.0], tcp.shape), np.broadcast_to([1.0, 0.0, 0.0], tcp.shape)
    return SprayPass(tcp, *map(np.array, ways), np.full(len(tcp) - 1, 50.0), jet, MADE_BY)


def strip(width, length=1000.0):
    return board_of(outline=box(-length / 2, -width / 2, length / 2, width / 2, ccw=True))


@pytest.mark.parametrize(("width", "percent"), [(23.0, 22.0), (40.0, 39.0), (60.0, 69.0), (80.0, 98.0)])
def test_a_ring_over_a_strip(width, percent):
    (landed,) = landed_shares(RECIPE, strip(width), [lane()])
    assert 100.0 * landed.share == pytest.approx(percent, abs=1.0)
    assert landed.height_mm == 60.0
    assert landed.seconds == pytest.approx(4.0)


def test_the_height_that_mends_it_makes_it_half():
    board = strip(40.0)
    (landed,) = landed_shares(RECIPE, board, [lane()])
    assert landed.mended_mm is not None
    (lower,) = landed_shares(RECIPE, board, [lane(height=landed.mended_mm)])
    assert lower.share == pytest.approx(0.5, abs=0.02)
    # Half of an ideal ring lies within 45 degrees of the lane: 20 mm = R / sqrt 2.
    assert landed.mended_mm == pytest.approx(20.0 * math.sqrt(2.0) / math.tan(math.radians(30.0)), rel=0.05)
    (finding,) = find_spray_beside(RECIPE, board, [lane()])
    assert "39% of the spray lands on the board from 60 mm" in finding.message
    assert f"From {landed.mended_mm:.0f} mm half of it would" in finding.message
    assert finding.made_by == MADE_BY
    assert find_spray_beside(RECIPE, strip(80.0), [lane()]) == []


def test_a_path_beside_the_board_is_not_mended_by_any_height():
    (finding,) = find_spray_beside(RECIPE, strip(40.0), [lane(y=60.0)])
    assert "keep the path farther inside" in finding.message


def test_dwells_count_by_their_time_and_gas_not_at_all():
    board = strip(60.0)
    still = Dwell(4.0, JET, MADE_BY)
    (both,) = landed_shares(RECIPE, board, [lane(x=(-20.0, 480.0)), lane(x=(480.0, 520.0)), still])
    (moving,) = landed_shares(RECIPE, board, [lane(x=(-20.0, 480.0)), lane(x=(480.0, 520.0))])
    assert both.seconds == pytest.approx(moving.seconds + 4.0)
    assert both.share < moving.share
    air = Jet("dry", "knife", "hot-air", 400.0, liquid=False)
    assert landed_shares(RECIPE, board, [lane(jet=air)]) == []
