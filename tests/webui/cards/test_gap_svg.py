"""The gap from above: what is drawn is where the model has it, turned as the part is."""

import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from cleaning_report import small_report
from hypothesis import given, settings
from hypothesis import strategies as st

from boards.undersides.underside import Joint
from webui.cards.drawings import SHOWN, drawing_of, gap_html, gap_svg, side_words, top_of

U1 = next(part for part in small_report().parts if part.component == "U1")


def turned(part, turn_rad):
    return replace(part, underside=replace(part.underside, turn_rad=turn_rad))


def squares(svg):
    """Colour of each drawn cell by its corner."""
    found = {}
    for path in ElementTree.fromstring(svg).iter("path"):
        if path.get("shape-rendering"):
            for x, y in re.findall(r"M(-?[\d.]+) (-?[\d.]+)h", path.get("d")):
                found[float(x), float(y)] = path.get("fill")
    return found


@pytest.mark.parametrize("shown", SHOWN.values())
def test_every_cell_is_drawn_once_where_it_is(shown):
    drawing = drawing_of(U1, 0, 0, "")
    field = drawing.gap.field
    drawn = squares(gap_svg(drawing, shown))
    assert len(drawn) == len(field.cells)
    step = np.array([1000 * field.length_m / field.shape[1], 1000 * field.width_m / field.shape[0]])
    corners = {tuple(np.round(centre, 2)) for centre in 1000 * field.centres - step / 2}
    assert {tuple(np.round(corner, 2)) for corner in drawn} == corners


def test_colours_rise_with_the_pressure():
    drawing = drawing_of(U1, 0, 0, "front")
    values = drawing.values("pressure")
    drawn = squares(gap_svg(drawing, "pressure"))
    front = [colour for (_, y), colour in drawn.items() if y < -1.3]
    back = [colour for (_, y), colour in drawn.items() if y > 1.1]
    reds = [int(colour[1:3], 16) for colour in front], [int(colour[1:3], 16) for colour in back]
    assert np.mean(reds[0]) > np.mean(reds[1]) + 20  # light colours hold more red than dark ones
    assert values.min() >= 0
    assert values.max() <= top_of("pressure", values)


@pytest.mark.parametrize(
    ("degrees", "words"),
    [
        (0, ("front", "right", "back", "left")),
        (90, ("right", "back", "left", "front")),
        (-90, ("left", "front", "right", "back")),
        (180, ("back", "left", "front", "right")),
        (30, ("front", "right", "back", "left")),
        (450, ("right", "back", "left", "front")),
    ],
)
def test_sides_are_called_as_they_lie_on_the_board(degrees, words):
    assert side_words(np.radians(degrees)) == words
    assert words[drawing_of(turned(U1, np.radians(degrees)), 0, 0, "front").side] == "front"


@settings(max_examples=20)
@given(turn=st.floats(-7, 7))
def test_a_turned_gap_fits_into_its_picture(turn):
    svg = ElementTree.fromstring(gap_svg(drawing_of(turned(U1, turn), 0, 0, ""), "residue"))
    left, top, wide, high = (float(each) for each in svg.get("viewBox").split())
    angle = float(re.search(r"rotate\((-?[\d.]+)\)", svg.find("g").get("transform"))[1])
    x, y = U1.underside.length_mm / 2, U1.underside.width_mm / 2
    rotation = np.radians(angle)
    corners = np.array([[x, y], [-x, y], [x, -y], [-x, -y]]) @ np.array(
        [[np.cos(rotation), np.sin(rotation)], [-np.sin(rotation), np.cos(rotation)]]
    )
    assert np.cos(rotation - turn) == pytest.approx(1.0, abs=1e-6)
    assert (np.abs(corners) <= np.array([-left, -top]) + 1e-3).all()
    assert (wide, high) == pytest.approx((-2 * left, -2 * top), abs=1e-3)


def test_arrows_run_away_from_the_jet():
    """Each arrow's tip lies farther from the front than its tail, seen over all arrows."""
    svg = gap_svg(drawing_of(U1, 0, 0, "front"), "pressure")
    path = next(each for each in ElementTree.fromstring(svg).iter("path") if each.get("stroke") == "#ffffff")
    shafts = re.findall(r"M(\S+) (\S+?)L(\S+) (\S+?)M", path.get("d"))
    assert len(shafts) > 20
    rises = np.array([float(y2) - float(y1) for _, y1, _, y2 in shafts])
    assert (rises > 0).mean() > 0.8


def test_joints_are_drawn_as_they_are():
    joints = (Joint(0.5, -0.5, 0.4, 0.4, round=True), Joint(0.0, 0.9, 1.0, 0.2, turn_rad=np.pi / 2))
    drawing = ElementTree.fromstring(gap_svg(replace(drawing_of(U1, 0, 0, ""), joints=joints), "shear"))
    circle = drawing.find(".//circle")
    assert (circle.get("cx"), circle.get("cy"), circle.get("r")) == ("0.5000", "-0.5000", "0.2000")
    assert any("rotate(90" in each.get("transform", "") for each in drawing.iter("rect"))


def test_where_nothing_flows_there_are_no_arrows():
    part = U1.gaps[0]
    still = replace(part.stages[0], edge_pa=(0.0,) * 8)
    svg = gap_svg(replace(drawing_of(U1, 0, 0, ""), result=still), "pressure")
    assert 'stroke="#ffffff"' not in svg
    assert len(squares(svg)) == len(part.field.cells)


def test_what_a_stage_does_not_touch_is_not_drawn():
    without = replace(U1, gaps=(replace(U1.gaps[0], stages=(None, U1.gaps[0].stages[1])),))
    assert drawing_of(without, 0, 0, "") is None
    assert drawing_of(without, 0, 1, "") is not None
    assert drawing_of(U1, 2, 0, "") is None
    assert drawing_of(small_report().parts[1], 0, 0, "") is None


def test_a_gap_says_its_numbers():
    html = gap_html(drawing_of(U1, 1, 1, ""), "residue")
    for wanted in ("75 µm", "opens: +90 Pa", "5.5 times", "front 805", "in the end 24.0 %", "worst tenth"):
        assert wanted in html
