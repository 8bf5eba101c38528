"""A parts table finds its components, whatever its form and frame; what it cannot place it lists."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import box

from boards.board import NOMINAL_HEIGHT, Body, Side
from boards.errors import BoardError
from boards.formats.prism import prism
from boards.parts_table.join import join_parts
from boards.parts_table.read import read_table
from boards.parts_table.tables import Statements, contradiction_findings
from specs.finding import Finding

PLACES = [(5.0, 5.0), (12.0, 6.0), (33.0, 4.0), (8.0, 21.0), (19.0, 17.0), (30.0, 26.0), (36.0, 15.0)]


def component(name: str, x: float, y: float, side: Side = "top", **known: object) -> Body:
    low, high = (1.6, 2.6) if side == "top" else (-1.0, 0.0)
    patches, normals, surfaces = prism(box(x - 1.0, y - 0.5, x + 1.0, y + 0.5), low, high)
    return Body(name, "component", patches, normals, surfaces, **known)  # type: ignore[arg-type]


def board_with(*components: Body) -> tuple[Body, ...]:
    patches, normals, surfaces = prism(box(0, 0, 40, 30), 0.0, 1.6)
    return (Body("board", "board", patches, normals, surfaces), *components)


def named() -> tuple[Body, ...]:
    return board_with(*(component(f"R{number}", x, y) for number, (x, y) in enumerate(PLACES, start=1)))


def nameless() -> tuple[Body, ...]:
    return board_with(*(component(f"part-{number}", x, y) for number, (x, y) in enumerate(PLACES, start=1)))


def join(folder: Path, bodies: tuple[Body, ...], text: str) -> tuple[dict[str, Body], dict[str, Finding]]:
    (folder / "parts.csv").write_text(text, encoding="utf-8")
    given = Statements((read_table(folder / "parts.csv"),))
    joined, notes = join_parts(bodies, given)
    notes = (*notes, *contradiction_findings(given.contradictions))
    assert len(joined) == len(bodies)
    return {body.name: body for body in joined}, {note.rule.id: note for note in notes}


KICAD_POS = """\
### Footprint positions - created by hand ###
## Unit = mm, Angle = deg.
## Side : All
# Ref     Val       Package                PosX       PosY       Rot  Side
R1        10k       R_0603               5.0000     5.0000   90.0000  top
R2        22k       R_0805              12.0000     6.0000    0.0000  top
## End
"""


@pytest.mark.parametrize(
    "text",
    [
        "Ref,Val,Package,PosX,PosY,Rot,Side\nR1,10k,R_0603,5,5,90,top\nR2,22k,R_0805,12,6,0,top\n",
        '"Ref","Val","Package","PosX","PosY","Rot","Side"\n"R1","10k","R_0603",5.000000,5.000000,90.0,top\n'
        '"R2","22k","R_0805",12.0,6.0,0,top\n',
        "Designator;Comment;Footprint;Mid X;Mid Y;Rotation;Layer\nR1;10k;R_0603;5,0mm;5,0mm;90;T\n"
        "R2;22k;R_0805;12,0mm;6,0mm;0;T",
        "REFDES\tVALUE\tPATTERN\tCenter-X(mil)\tCenter-Y(mil)\tLayer\nR1\t10k\tR_0603\t196.85\t196.85\tTopLayer\n"
        "R2\t22k\tR_0805\t472.44\t236.22\tTopLayer\n",
        "Altium Designer Pick and Place Locations\nC:\\jobs\\board.PcbDoc\n\n"
        "Designator,Comment,Footprint,Layer,Center-X(mm),Center-Y(mm)\n"
        "R1,10k,Lib:R_0603,Top Layer,5,5\nR2,22k,Lib:R_0805,Top Layer,12,6\n",
        "\ufeffReference,Value,Footprint\nR1,10k,R_0603\r\nr2,22k,R_0805\r\n",
        KICAD_POS,
        KICAD_POS.replace("mm,", "inches,").replace(" 5.0000", " 0.196850").replace("12.0000", "0.472441"),
    ],
)
def test_the_usual_forms_say_the_same(tmp_path: Path, text: str) -> None:
    bodies, notes = join(tmp_path, named(), text)
    assert (bodies["R1"].value, bodies["R1"].package) == ("10k", "R_0603")
    assert (bodies["R2"].value, bodies["R2"].package) == ("22k", "R_0805")
    assert bodies["R3"].package is None
    assert notes["parts-not-in-table"].message.startswith("5 components")
    assert "R3, R4, R5, R6, R7" in notes["parts-not-in-table"].message
    assert "parts-not-on-board" not in notes


def test_positions_in_mil_lie_where_positions_in_mm_lie(tmp_path: Path) -> None:
    rows = "".join(f"Q{n},{x / 0.0254:.4f}mil,{y / 0.0254:.4f}mil\n" for n, (x, y) in enumerate(PLACES))
    bodies, notes = join(tmp_path, nameless(), "Ref,X,Y\n" + rows)
    assert set(bodies) == {"board", *(f"Q{n}" for n in range(len(PLACES)))}
    assert "parts-frame" not in notes


def test_columns_of_fixed_width_may_hold_blanks_or_nothing(tmp_path: Path) -> None:
    text = (
        "Altium Designer Pick and Place Locations\nC:\\Boards\\card.PcbDoc\n\n==========\nUnits used:   mil\n\n"
        "Designator Comment       Layer       Footprint   Center-X Center-Y Rotation Description\n"
        "R1         10k 1% thick  TopLayer    R0603       196.8504 196.8504 90       Chip resistor\n"
        "R2                       TopLayer    R0805       472.4409 236.2205 0        \n"
    )
    bodies, notes = join(tmp_path, named(), text)
    assert (bodies["R1"].value, bodies["R1"].package) == ("10k 1% thick", "R0603")
    assert (bodies["R2"].value, bodies["R2"].package) == (None, "R0805")
    assert "parts-frame" not in notes


def test_a_line_for_both_sides_states_none(tmp_path: Path) -> None:
    bodies, _ = join(tmp_path, named(), "Ref,Value,Side\nR1 R2,10k,TB\nR3,1k,both\n")
    assert [bodies[name].value for name in ("R1", "R2", "R3")] == ["10k", "10k", "1k"]


def test_a_bill_of_materials_names_many_at_once(tmp_path: Path) -> None:
    text = 'Reference,Value,MPN,Pins,Standoff (mm)\n"R1, R2 R4-R6",10k,RC0603,2,"0,05"\nR9,1k,X,2,\n'
    bodies, notes = join(tmp_path, named(), text)
    for name in ("R1", "R2", "R4", "R5", "R6"):
        assert (bodies[name].value, bodies[name].part, bodies[name].pins) == ("10k", "RC0603", 2)
        assert bodies[name].gap_height_mm == pytest.approx(0.05)
    assert bodies["R3"].value is None
    assert "R9" in notes["parts-not-on-board"].message
    assert "R3, R7" in notes["parts-not-in-table"].message


def test_the_table_wins_and_the_contradiction_is_said(tmp_path: Path) -> None:
    bodies = board_with(component("U1", 5, 5, package="SOIC-8", pins=8, value="LM358"))
    joined, notes = join(tmp_path, bodies, "Ref,Package,Value\nU1,MSOP-8,lm358\n")
    assert joined["U1"].package == "MSOP-8"
    assert notes["parts-contradict"].severity == "warning"
    assert "U1 package MSOP-8 (parts.csv), not SOIC-8 (board)" in notes["parts-contradict"].message
    joined, notes = join(tmp_path, bodies, "Ref,Pins,Value\nU1,10,lm358\n")
    assert joined["U1"].pins == 10
    assert "U1 pins 10 (parts.csv), not 8 (board)" in notes["parts-contradict"].message
    assert "358" not in notes["parts-contradict"].message


def test_an_empty_cell_takes_nothing_away(tmp_path: Path) -> None:
    bodies = board_with(component("U1", 5, 5, package="SOIC-8", pins=8, side="top"))
    joined, notes = join(tmp_path, bodies, "Ref,Package,Pins,Side,Standoff\nU1,,,,\n")
    assert (joined["U1"].package, joined["U1"].pins, joined["U1"].gap_height_mm) == ("SOIC-8", 8, None)
    assert not notes


def test_a_side_that_the_body_contradicts_is_refused(tmp_path: Path) -> None:
    joined, notes = join(tmp_path, board_with(component("U1", 5, 5)), "Ref,Side\nU1,bottom\n")
    assert joined["U1"].side == "top"
    assert "U1 side top (board), not bottom (parts.csv)" in notes["parts-contradict"].message


def test_a_coarser_package_does_not_replace_a_finer_one(tmp_path: Path) -> None:
    joined, notes = join(tmp_path, board_with(component("U1", 5, 5, package="SOIC-8")), "Ref,Package\nU1,IC\n")
    assert joined["U1"].package == "SOIC-8"
    assert "U1 package SOIC-8 (board), not IC (parts.csv)" in notes["parts-contradict"].message


def test_a_height_that_its_package_cannot_have_is_not_believed(tmp_path: Path) -> None:
    bodies = board_with(component("U1", 5, 5, package="SOIC-8", extra=((NOMINAL_HEIGHT, "family"),)))
    joined, notes = join(tmp_path, bodies, "Ref,Height\nU1,17.5\n")
    assert joined["U1"].patches[:, :, 2].max() == pytest.approx(1.6 + 1.75)
    assert "U1 height 1.75 mm (family SOIC" in notes["parts-contradict"].message


@pytest.mark.parametrize("side", ["top", "bottom"])
def test_a_stated_height_replaces_a_nominal_one(tmp_path: Path, side: Side) -> None:
    bodies = board_with(component("L1", 5, 5, side, extra=((NOMINAL_HEIGHT, "nominal"),)))
    joined, _ = join(tmp_path, bodies, "Ref,Height [mm],Standoff\nL1,4.5,0.2\n")
    heights = joined["L1"].patches[:, :, 2]
    expected = (1.8, 6.1) if side == "top" else (-4.5, -0.2)
    assert (heights.min(), heights.max()) == pytest.approx(expected)
    assert joined["L1"].extra == ()
    assert bodies[1].patches[:, :, 2].max() == pytest.approx(2.6 if side == "top" else 0.0)


def test_a_drawn_height_stays_and_a_difference_is_said(tmp_path: Path) -> None:
    bodies = board_with(component("L1", 5, 5), component("L2", 15, 5))
    joined, notes = join(tmp_path, bodies, "Ref,Height\nL1,1.05\nL2,7\n")
    assert joined["L2"].patches[:, :, 2].max() == pytest.approx(2.6)
    assert "L2 height 1.00 mm (board), not 7 mm (parts.csv)" in notes["parts-contradict"].message
    assert "L1" not in notes["parts-contradict"].message


@pytest.mark.slow
@given(
    turns=st.integers(0, 3),
    mirror=st.sampled_from([1.0, -1.0]),
    shift=st.tuples(st.floats(-500, 500), st.floats(-500, 500)),
    order=st.permutations(range(len(PLACES))),
    missing=st.integers(0, 2),
)
@settings(max_examples=40)
def test_a_mirrored_turned_and_shifted_table_finds_every_part(
    tmp_path: Path, turns: int, mirror: float, shift: tuple[float, float], order: list[int], missing: int
) -> None:
    turn = np.linalg.matrix_power(np.array([[0.0, -1.0], [1.0, 0.0]]), turns) @ np.diag([mirror, 1.0])
    rows = [f"U{n},{x:.4f},{y:.4f}" for n in order[missing:] for x, y in [turn @ np.array(PLACES[n]) + shift]]
    bodies, notes = join(tmp_path, nameless(), "Ref,PosX,PosY\n" + "\n".join(rows))
    for number in order[missing:]:
        found = bodies[f"U{number}"].patches.reshape(-1, 3)[:, :2].mean(axis=0)
        np.testing.assert_allclose(found, PLACES[number], atol=0.6)
    message = notes["parts-frame"].message if "parts-frame" in notes else ""
    if turns or mirror < 0:
        assert "mirrored" in message or "turned" in message
    assert ("parts-not-in-table" in notes) == (missing > 0)


def test_a_mirrored_table_with_known_names_is_recognised(tmp_path: Path) -> None:
    rows = "\n".join(f"R{n},{-x + 40},{y}" for n, (x, y) in enumerate(PLACES, start=1))
    _, notes = join(tmp_path, named(), "Ref,PosX,PosY\n" + rows)
    assert "mirrored in x" in notes["parts-frame"].message
    assert "40.000" in notes["parts-frame"].message
    assert "parts-position" not in notes


def test_the_bottom_may_be_mirrored_alone(tmp_path: Path) -> None:
    tops = [component(f"part-{n}", x, y) for n, (x, y) in enumerate(PLACES)]
    unders = [component(f"part-{n + 50}", x, y + 1.0, "bottom") for n, (x, y) in enumerate(PLACES)]
    rows = [f"R{n},{x},{y},top" for n, (x, y) in enumerate(PLACES)]
    rows += [f"C{n},{-x},{y + 1.0},bottom" for n, (x, y) in enumerate(PLACES)]
    bodies, notes = join(tmp_path, board_with(*tops, *unders), "Ref,PosX,PosY,Side\n" + "\n".join(rows))
    assert "bottom" in notes["parts-frame"].message
    for number, (x, y) in enumerate(PLACES):
        assert bodies[f"R{number}"].side == "top"
        assert bodies[f"C{number}"].side == "bottom"
        centre = bodies[f"C{number}"].patches.reshape(-1, 3)[:, :2].mean(axis=0)
        np.testing.assert_allclose(centre, [x, y + 1.0], atol=0.6)


def test_a_part_that_was_moved_since_is_said(tmp_path: Path) -> None:
    rows = [f"R{n},{x},{y}" for n, (x, y) in enumerate(PLACES, start=1)]
    rows[2] = "R3,20.0,10.0"
    _, notes = join(tmp_path, named(), "Ref,PosX,PosY\n" + "\n".join(rows))
    assert "1 components lie elsewhere" in notes["parts-position"].message
    assert "R3" in notes["parts-position"].message


def test_positions_that_fit_nothing_join_nothing(tmp_path: Path) -> None:
    rows = "\n".join(f"U{n},{3.1 * n},{n * n}" for n in range(9))
    bodies, notes = join(tmp_path, nameless(), "Ref,PosX,PosY\n" + rows)
    assert all(name == "board" or name.startswith("part-") for name in bodies)
    assert notes["parts-not-on-board"].message.startswith("9 rows")
    assert notes["parts-not-in-table"].message.startswith("7 components")
    assert notes["parts-position"].severity == "warning"


@pytest.mark.parametrize("hits", [1, 2, 3])
def test_less_than_half_of_the_positions_join_nothing(tmp_path: Path, hits: int) -> None:
    off = [(200.0 + 3.1 * n, 300.0 + n * n) for n in range(len(PLACES) - hits)]
    rows = "\n".join(f"U{n},{x},{y}" for n, (x, y) in enumerate([*PLACES[:hits], *off]))
    bodies, _ = join(tmp_path, nameless(), "Ref,PosX,PosY\n" + rows)
    assert all(name == "board" or name.startswith("part-") for name in bodies)


def test_a_symmetric_arrangement_is_not_guessed(tmp_path: Path) -> None:
    corners = [(5, 5), (35, 5), (5, 25), (35, 25)]
    bodies = board_with(*(component(f"part-{n}", x, y) for n, (x, y) in enumerate(corners)))
    rows = "\n".join(f"U{n},{y + 200},{x}" for n, (x, y) in enumerate(corners))
    joined, notes = join(tmp_path, bodies, "Ref,PosX,PosY\n" + rows)
    assert "U0" not in joined
    assert "parts-position" in notes


def test_a_body_with_a_designator_keeps_its_name(tmp_path: Path) -> None:
    bodies = board_with(*(component(f"D{n}", x, y) for n, (x, y) in enumerate(PLACES)))
    rows = "\n".join(f"U{n},{x},{y},P{n}" for n, (x, y) in enumerate(PLACES))
    joined, _ = join(tmp_path, bodies, "Ref,PosX,PosY,Package\n" + rows)
    assert [joined[f"D{n}"].package for n in range(len(PLACES))] == [f"P{n}" for n in range(len(PLACES))]


def test_twenty_names_are_listed_and_the_rest_counted(tmp_path: Path) -> None:
    rows = "\n".join(f"Z{n},1k" for n in range(33))
    _, notes = join(tmp_path, named(), "Ref,Value\n" + rows)
    assert notes["parts-not-on-board"].message.startswith("33 rows")
    assert "Z19 and 13 more" in notes["parts-not-on-board"].message


@pytest.mark.parametrize(
    ("text", "line", "says"),
    [
        ("Ref,Pins\nR1,two\n", 2, "column Pins: 'two'"),
        ("Ref,Pins\n\nR1,-3\n", 3, "column Pins: '-3'"),
        ("Ref,PosX,PosY\nR1,left,3\n", 2, "column PosX: 'left'"),
        ("Ref,PosX,PosY\nR1,1.2.3,3\n", 2, "column PosX: '1.2.3'"),
        ("Ref,PosX,PosY\nR1,1km,3\n", 2, "column PosX: '1km'"),
        ("Ref,Side\nR1,left\n", 2, "neither top nor bottom"),
        ("Ref,Standoff\nR1,-0.1\n", 2, "must not be negative"),
        ("Ref,Height\nR1,nan\n", 2, "column Height: 'nan'"),
        ("", None, "no line names the columns"),
        ("a,b\n1,2\n", None, "no line names the columns"),
    ],
)
def test_a_bad_table_names_line_and_column(tmp_path: Path, text: str, line: int | None, says: str) -> None:
    with pytest.raises(BoardError, match=re.escape(says)) as caught:
        join(tmp_path, named(), text)
    assert caught.value.line == line
    assert str(caught.value).startswith(str(tmp_path / "parts.csv"))


def test_a_missing_table_and_a_picture_are_refused(tmp_path: Path) -> None:
    with pytest.raises(BoardError, match="no such file"):
        read_table(tmp_path / "none.csv")
    with pytest.raises(BoardError, match="directory"):
        read_table(tmp_path)
    (tmp_path / "x.csv").write_bytes(b"\x89PNG\0\0\0")
    with pytest.raises(BoardError, match="not a text table"):
        read_table(tmp_path / "x.csv")


def test_other_encodings_are_read(tmp_path: Path) -> None:
    for encoding in ("utf-16", "cp1252"):
        (tmp_path / "x.csv").write_bytes("Ref;Value\nR1;4,7 µF\n".encode(encoding))
        assert join_parts(named(), Statements((read_table(tmp_path / "x.csv"),)))[0][1].value == "4,7 µF"


@pytest.mark.slow
@given(text=st.text(alphabet='Ref,;\t"#\n 1.5mPosXYSide-µ', max_size=120))
@settings(max_examples=100)
def test_any_text_is_read_or_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "x.csv").write_bytes(("Ref,PosX,PosY,Side\n" + text).encode("utf-8"))
    message, bodies = "", ()
    try:
        bodies, _ = join_parts(named(), Statements((read_table(tmp_path / "x.csv"),)))
    except BoardError as error:
        message = str(error)
    assert message.startswith(str(tmp_path)) or len(bodies) == len(named())


def test_a_range_of_endless_digits_is_a_name_like_others(tmp_path: Path) -> None:
    nines = "9" * 5000
    bodies, notes = join(tmp_path, named(), f"Ref,Height\nR1,2\nR{nines}-R{nines},1\n")
    assert bodies["R1"].value is None
    assert ".csv are not on the board" in notes["parts-not-on-board"].message


def test_a_height_that_the_file_states_otherwise_is_a_contradiction(tmp_path: Path) -> None:
    """The table wins; of a height that only follows from the package there is nothing to contradict."""
    for source, count in (("stated", 1), ("family SOIC", 0)):
        bodies = board_with(component("U1", 5, 5, package="SOIC-8", extra=((NOMINAL_HEIGHT, source),)))
        joined, notes = join(tmp_path, bodies, "Ref,Height\nU1,1.4\n")
        assert joined["U1"].patches[:, :, 2].max() == pytest.approx(1.6 + 1.4)
        assert len(notes) == count
    bodies = board_with(component("U1", 5, 5, package="SOIC-8", extra=((NOMINAL_HEIGHT, "stated"),)))
    assert "U1 height 1.4 mm (parts.csv), not 1.00 mm (board)" in join(tmp_path, bodies, "Ref,Height\nU1,1.4\n")[1][
        "parts-contradict"].message  # fmt: skip
