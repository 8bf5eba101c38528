from itertools import pairwise

import numpy as np
import pytest
from analysed import PARAMETERS, board_of, bodies_of, prepared_of
from hostile import at, body

from boards.undersides.underside import undersides_of
from boards.understand import understand
from cleaning.gap.edge_segments import SEGMENTS
from cleaning.parameters.model import PartOverride
from cleaning.prepared_board import prepare


def ready(board, *parts):
    return prepare(board, PARAMETERS.model_copy(update={"parts": list(parts)}), lambda *_: None)


def chip(name, x, y, width=2.0, depth=1.25, side="top"):
    low = 0.0 if side == "top" else -2.4
    return body(
        name, "component", at(x, y, width, depth), low, low + 0.8, package="C_0805_2012Metric", pins=2, side=side
    )


def test_only_parts_over_a_thin_gap_have_edges_and_fields():
    prepared = prepared_of()
    assert [each.component for each in prepared.undersides] == ["U1", "C1"]
    assert prepared.rows == (0, 1)
    assert prepared.edges.middles.shape == (2, SEGMENTS, 3)
    for underside, fields in zip(prepared.undersides, prepared.fields, strict=True):
        assert len(fields) == len(underside.cases)
        assert fields[0].length_m == pytest.approx(1e-3 * underside.length_mm, abs=1e-6)
    assert len(prepared.overrides) == 3
    assert prepared.facets.cell_component.max() == 2


def test_rows_point_into_the_components_of_the_board():
    prepared = ready(board_of("J1", "C1", "U1"))
    names = [component.name for component in prepared.board.components]
    assert [names[row] for row in prepared.rows] == [each.component for each in prepared.undersides] == ["C1", "U1"]


def test_alike_gaps_are_solved_once_wherever_and_however_they_lie():
    more = (chip("C3", 5, 5), chip("C4", 20, 30), chip("C5", 40, 5, 1.25, 2.0), chip("C6", 20, 5, side="bottom"))
    board = understand(bodies_of("C1", more=more), "small")
    fields = {each.component: fields for each, fields in zip(undersides_of(board), ready(board).fields, strict=True)}
    assert len(fields) == 5
    for case in range(2):
        assert len({id(each[case]) for each in fields.values()}) == 1
    assert fields["C1"][0] is not fields["C1"][1]


def test_other_sizes_are_solved_anew():
    board = understand(bodies_of("C1", more=(chip("C3", 5, 5, 2.2, 1.25),)), "small")
    one, other = ready(board).fields
    assert one[0] is not other[0]


@pytest.mark.parametrize("pattern", ["U1", "U*", "QFN-16*"])
def test_what_is_known_of_a_part_is_found_by_its_name_or_package(pattern):
    known, later = PartOverride(match=[pattern], most_kpa=2.0), PartOverride(match=["*"], most_kpa=9.0)
    prepared = ready(board_of("U1", "C1"), known, later)
    assert prepared.overrides == (known, later)


def test_nothing_is_known_of_what_nothing_matches():
    (found,) = ready(board_of("C1"), PartOverride(match=["c1", "U*"], most_kpa=2.0)).overrides
    assert found.most_kpa is None
    assert found.paste_factor is None
    assert found.standoff_um is None


@pytest.mark.parametrize(("stated", "wanted"), [((30.0, 80.0), [0.03, 0.08]), ((40.0, 40.0), [0.04])])
def test_a_stated_standoff_counts_and_the_lower_bound_comes_first(stated, wanted):
    prepared = ready(board_of("U1", "C1"), PartOverride(match=["C1"], standoff_um=stated))
    under, free = prepared.undersides[1], undersides_of(prepared.board)[1]
    assert [case.gap_height_mm for case in under.cases] == pytest.approx(wanted)
    assert under.gap_height_source == "stated in the parameter set"
    assert under.cases[0].joints == free.cases[0].joints
    assert [1e3 * field.height_m for field in prepared.fields[1]] == pytest.approx(wanted)
    assert prepared.undersides[0].gap_height_source != under.gap_height_source


def test_a_stated_standoff_leaves_the_bounds_of_unknown_joints():
    strange = body(
        "X1", "component", at(20, 10, 6, 6), 0.0, 1.0, package="MODULE", pins=4, side="top", gap_height_mm=0.1
    )
    board = understand(bodies_of(more=(strange,)), "small")
    (free,) = undersides_of(board)
    assert free.cases[0].joints != free.cases[1].joints
    (under,) = ready(board, PartOverride(match=["X1"], standoff_um=(40.0, 40.0))).undersides
    assert [case.gap_height_mm for case in under.cases] == pytest.approx([0.04, 0.04])
    assert [case.joints for case in under.cases] == [case.joints for case in free.cases]


def test_progress_goes_from_nothing_to_all():
    told = []
    prepare(board_of("U1"), PARAMETERS, lambda _, done: told.append(done))
    assert (told[0], told[-1]) == (0.0, 1.0)
    assert all(before <= after for before, after in pairwise(told))


def test_a_bare_board_has_facets_and_nothing_beneath():
    prepared = prepared_of(())
    assert (prepared.undersides, prepared.rows, prepared.fields, prepared.overrides) == ((), (), (), ())
    assert prepared.edges.middles.shape == (0, SEGMENTS, 3)
    assert np.all(prepared.facets.cell_component == -1)
