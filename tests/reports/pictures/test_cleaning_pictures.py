from dataclasses import replace
from io import BytesIO
from xml.etree import ElementTree

import numpy as np
import pytest
from cleaning_report import small_report, soaked_report
from PIL import Image

from cleaning.undersides.residue import GapStage
from cleaning.verdicts.exposed_area import shown_on_side
from reports.pictures.cleaning_pictures import (
    VERDICT_COLOURS,
    draw_exposures,
    draw_limiting,
    draw_reach,
    draw_verdicts,
    draw_volumes,
    growth_of,
    see_cells,
    times_needed,
)
from reports.pictures.gap_picture import draw_gaps, gap_drawing, pressed_side, strongest_stage
from reports.pictures.sheet import ACCENT, view_of


def has_colour(png: bytes, colour: str) -> bool:
    pixels = np.asarray(Image.open(BytesIO(png)).convert("RGB"))
    wanted = [int(colour[place : place + 2], 16) for place in (1, 3, 5)]
    return bool((pixels == wanted).all(axis=2).sum() > 50)


def washed():
    """The small report without its rinse."""
    report = small_report()
    return replace(report, stages=report.stages[:1], exposures=report.exposures[:1])


def upside_down(stage):
    flipped = stage.samples.axes * np.array([1.0, -1.0, -1.0])
    return replace(stage, samples=replace(stage.samples, axes=flipped))


def test_every_verdict_has_its_colour_on_the_board():
    (dry,), (wet,) = draw_verdicts(small_report()), draw_verdicts(soaked_report())
    for picture, none in ((dry, "clean, wet"), (wet, "clean")):
        ElementTree.fromstring(picture.content)
        for said, colour in VERDICT_COLOURS.items():
            assert (colour.encode() in picture.content) == (said not in (none, "avoided"))


def test_colours_differ_also_in_grey():
    """What is clean and stays wet stands off from all others by its lightness alone (CIE 1976 L*)."""

    def lightness(colour):
        screen = np.array([int(colour[place : place + 2], 16) / 255 for place in (1, 3, 5)])
        light = np.where(screen <= 0.04045, screen / 12.92, ((screen + 0.055) / 1.055) ** 2.4)
        return 116 * np.cbrt(light @ [0.2126, 0.7152, 0.0722]) - 16

    wet = lightness(VERDICT_COLOURS["clean, wet"])
    assert min(abs(lightness(each) - wet) for said, each in VERDICT_COLOURS.items() if said != "clean, wet") > 12


@pytest.mark.slow
def test_what_the_jet_never_hits_stands_out_and_nothing_does_where_all_is_hit():
    report = washed()
    ((_, picture),) = draw_exposures(report)
    assert has_colour(picture.content, ACCENT)
    everywhere = replace(report.exposures[0], **{
        name: np.maximum(getattr(report.exposures[0], name), 1.0)
        for name in ("volume_mm", "front_s", "cone_s", "peak_pa")
    })  # fmt: skip
    ((_, picture),) = draw_exposures(replace(report, exposures=(everywhere,)))
    assert not has_colour(picture.content, ACCENT)


@pytest.mark.slow
def test_the_side_that_is_sprayed_is_the_one_that_is_drawn():
    report = small_report()
    below = upside_down(report.stages[0])
    told = draw_exposures(replace(report, stages=(report.stages[0], below)))
    assert [picture.alt.split(", ")[1] for _, picture in told] == ["top side", "bottom side"]


@pytest.mark.slow
def test_what_does_not_belong_to_the_side_is_left_out_of_its_pictures():
    report = washed()
    ((_, picture),) = draw_exposures(report)
    missed = np.where(shown_on_side(report.facets, report.board, "top"), 1.0, 0.0)
    only_outside = replace(report.exposures[0], volume_mm=missed, front_s=missed, cone_s=missed, peak_pa=missed)
    ((_, other),) = draw_exposures(replace(report, exposures=(only_outside,)))
    assert has_colour(picture.content, ACCENT)
    assert not has_colour(other.content, ACCENT)


def test_the_share_that_has_enough_grows_to_what_the_end_shows():
    report = small_report()
    areas = np.where(shown_on_side(report.facets, report.board, "top"), report.facets.cell_areas_mm2, 0.0)
    times, shares = growth_of(report.exposures[0], areas, 5.0, report.run_off["top"])
    assert (np.diff(shares) >= 0).all()
    assert times[-1] == pytest.approx(report.stages[0].end_s)
    enough = areas[report.exposures[0].volume_mm >= 5.0].sum() / areas.sum()
    assert shares[-1] == pytest.approx(enough, abs=0.01)


def result_of(*edge):
    nothing = np.zeros(1, np.float32)
    return GapStage(0.0, True, edge, (0.0,) * 4, nothing, 0.0, 0.0, 0.0, 0.0, nothing)


def test_only_the_side_that_drives_most_flow_is_pressed():
    part = small_report().parts[0]
    result = result_of(10.0, 10.0, 30.0, 20.0, 5.0, 5.0, 4.0, 5.0)
    gap = replace(part.gaps[0], stages=(result, None))
    drawing = gap_drawing(replace(part, gaps=(gap,)), 0, 0)
    assert drawing is not None
    assert drawing.side == pressed_side(gap.field, result) == 1
    assert drawing.pressures.tolist() == [0, 0, 30, 20, 0, 0, 0, 0]


def test_a_gap_that_nothing_flows_through_has_no_arrows():
    part = small_report().parts[0]
    gap = replace(part.gaps[0], stages=(result_of(*[0.0] * 8), None))
    drawing = gap_drawing(replace(part, gaps=(gap,)), 0, 0)
    assert drawing is not None
    assert [ends.shape for ends in drawing.arrows()] == [(0, 2), (0, 2)]


def test_a_side_that_joints_close_drives_nothing_however_hard_it_is_pressed():
    field = small_report().parts[0].gaps[0].field
    velocity = field.velocity.copy()
    velocity[2:4] = 0.0
    hard = result_of(10.0, 10.0, 900.0, 900.0, 5.0, 5.0, 4.0, 5.0)
    assert pressed_side(replace(field, velocity=velocity), hard) == 0


def test_a_gap_is_drawn_from_the_wash_that_presses_it_hardest():
    report = small_report()
    gap = report.parts[0].gaps[0]
    assert strongest_stage(report, gap) == 0
    assert strongest_stage(report, replace(gap, stages=(None, gap.stages[1]))) == 1
    assert strongest_stage(report, replace(gap, stages=(None, None))) is None


@pytest.mark.slow
def test_gaps_can_be_drawn_even_if_nothing_ever_acted_on_them():
    report = small_report()
    part = report.parts[0]
    idle = replace(part, gaps=tuple(replace(gap, stages=(None, None)) for gap in part.gaps))
    ElementTree.fromstring(draw_gaps(report, idle).content)
    assert draw_gaps(report, part).content == draw_gaps(report, part).content


def test_a_curve_needs_a_liquid_and_bars_need_an_elasticity():
    report = small_report()
    dry = tuple(replace(stage, use="dry") for stage in report.stages)
    assert draw_volumes(report) is not None
    assert draw_volumes(replace(report, stages=dry)) is None
    assert draw_limiting([part for part in report.parts if not part.limiting]) is None


@pytest.fixture(scope="module")
def seen():
    report = small_report()
    return see_cells(report.facets, "top", view_of(report.board), 300)


def pixel_of(seen, x, y):
    rows, columns = seen.cell.shape
    (x0, y0), (x1, y1) = seen.view.low, seen.view.high
    return int((y1 - y) / (y1 - y0) * rows), int((x - x0) / (x1 - x0) * columns)


def test_each_pixel_shows_the_cell_that_lies_there(seen):
    centres = small_report().facets.cell_centres
    for x, y in ((3.5, 2.5), (20.5, 17.5), (12.5, 8.5)):
        cell = seen.cell[pixel_of(seen, x, y)]
        assert np.abs(centres[cell][:2] - (x, y)).max() < 1e-6


def test_a_component_hides_the_board_beneath_it(seen):
    facets = small_report().facets
    top = seen.cell[pixel_of(seen, 9.0, 12.0)]
    assert small_report().board.components[facets.cell_component[top]].name == "U1"
    assert facets.cell_centres[top][2] > 0.5


def test_what_is_outside_of_the_board_has_no_value(seen):
    values = seen.filled(np.ones(len(small_report().facets.cell_areas_mm2)))
    assert np.isnan(values[0, 0])
    assert np.nanmin(values) == np.nanmax(values) == 1.0


def test_the_bottom_of_a_board_that_has_no_facets_there_is_empty():
    report = small_report()
    facing_down = see_cells(report.facets, "bottom", view_of(report.board), 100)
    assert not np.isin(facing_down.cell, np.flatnonzero(report.facets.cell_normals[:, 2] > 0.9)).any()


def test_multiples_count_run_off_and_repeats_and_never_hit_is_nothing() -> None:
    report = small_report()
    (wash,) = [
        (stage, exposure)
        for stage, exposure in zip(report.stages, report.exposures, strict=True)
        if (stage.use, stage.side) == ("wash", "top")
    ]
    times = times_needed(report, "top", "wash")
    limits = report.parameters.limits
    expected = wash[1].supply_mm / (limits.margin * limits.wash_volume_mm)
    hit = wash[1].volume_mm > 0
    np.testing.assert_allclose(times[hit], np.broadcast_to(expected, times.shape)[hit])
    assert not times[~hit].any()
    often = replace(report, stages=tuple(replace(stage, repeats=3) for stage in report.stages))
    np.testing.assert_allclose(times_needed(often, "top", "wash"), 3.0 * times)
    assert not times_needed(report, "bottom", "wash").any()


@pytest.mark.slow
def test_the_same_part_gives_the_same_picture_and_a_side_without_liquid_none() -> None:
    report = small_report()
    part = report.parts[0]
    picture = draw_reach(report, part)
    assert picture is not None
    assert picture == draw_reach(report, part)
    assert part.component in picture.alt
    assert draw_reach(replace(report, stages=(), exposures=()), part) is None
