import io
import re
import zipfile
from dataclasses import replace
from functools import cache

import pytest
from installations import ARM_LANGUAGES, for_language
from small_page import find, press, small_page
from small_scene import SmallScene
from tiny_session import tiny_session

from programs.export import export
from programs.motion.steps import Line, Reach
from programs.plan import SprayPass
from programs.posts.dialects import DIALECTS
from programs.posts.rebuilt import TextPlace
from reports.files.robot_programs import tracking_of, write_tracked
from robotcell.cell.installation import installation_of
from robotcell.cell.load import read_cell
from specs.source import NO_SOURCE, Source
from webui.downloads.program_text import (
    PAGE_LINES,
    TextFile,
    cited_makers,
    find_text,
    link_text,
    match_lines,
    next_move,
    page_html,
    zip_bytes,
)
from webui.layers.paths.nozzle import motion_glb
from webui.page.evaluations import check_program
from webui.panels.robot.program import TextPreview
from webui.theme.palette import CHOSEN_GROUND, GROUND, css_colour

pytestmark = pytest.mark.slow

J1 = Source(0, "around", ("J1",))


def written(dialect="abb"):
    installation = for_language(installation_of(read_cell("ur5e-bench")), dialect)
    return link_text(dialect, export(tiny_session().run.program, installation, dialect))


@cache
def tracked():
    return check_program(tiny_session().run, read_cell("ur5e-bench"), lambda _what, _done: None)


@cache
def tracked_text(dialect):
    done = tracked()
    installation = for_language(installation_of(done.cell), dialect)
    return link_text(dialect, export(done.program, installation, dialect, tracking_of(done.report)))


@pytest.mark.parametrize("dialect", [name for name in ARM_LANGUAGES if name not in ("linuxcnc", "joint-table")])
def test_text_and_place_belong_together(dialect):
    """What the language's own reader finds in the text, motion by motion, is where the page shows it."""
    done = tracked_text(dialect)
    assert done.places_known
    moves = [move for file in done.files for move in file.moves if move is not None]
    read = [step.target for step in DIALECTS[dialect].read(done.exported.files).steps if hasattr(step, "target")]
    assert len(moves) == len(read)
    for move, target in zip(moves, read, strict=True):
        assert move.target.position == pytest.approx(target.position, abs=0.02)


@pytest.mark.parametrize("dialect", list(ARM_LANGUAGES))
def test_every_sprayed_stroke_is_found_in_every_language(dialect):
    done = tracked_text(dialect)
    makers = {item.made_by for item in tiny_session().run.plan.items if isinstance(item, SprayPass)}
    assert len(makers) > 5
    for made_by in makers:
        index, number = find_text(done.files, made_by)
        assert done.files[index].makers[number - 1] == made_by


@pytest.mark.parametrize("dialect", [name for name, each in ARM_LANGUAGES.items() if each.controller is not None])
def test_the_program_is_driven_in_every_language(dialect):
    """Also where a line is divided so near its end for an output that the rest of it has no extent."""
    exported = tracked_text(dialect).exported
    driven = exported.drive(tracked().program)
    assert driven.totals.duration_s == pytest.approx(exported.forecast.predicted_s)
    assert driven.totals.travel_mm == pytest.approx(tracked().program.totals.travel_mm, rel=1e-3)


@pytest.mark.parametrize("dialect", ["ur", "joint-table"])
def test_the_page_writes_what_the_command_line_writes(dialect):
    done = tracked()
    assert dict(write_tracked(done.report, done.cell, dialect).files) == dict(tracked_text(dialect).exported.files)


def test_the_first_text_of_a_stroke_is_found_and_leads_back():
    done = written()
    for file in done.files:
        for number, move in enumerate(file.moves, start=1):
            assert file.makers[number - 1] == (NO_SOURCE if move is None else move.made_by)
    index, number = find_text(done.files, J1)
    assert J1 not in done.files[index].makers[: number - 1]
    assert find_text(done.files, "nobody") is None
    assert find_text(done.files, "") is None


def test_stepping_goes_from_motion_to_motion_and_stays_at_the_ends():
    file = written().files[0]
    at, seen = 1, []
    while (then := next_move(file, at, 1)) != at:
        at = then
        seen.append(at)
    assert seen == [number for number, move in enumerate(file.moves, start=1) if move is not None]
    assert next_move(file, seen[0], -1) == seen[0]
    assert next_move(file, seen[1], -1) == seen[0]


def test_text_that_cannot_be_matched_is_shown_without_places():
    line = next(move for move in written().files[0].moves if isinstance(move, Line))
    places = [TextPlace("a", 1), TextPlace("a", 3)]
    cited = match_lines({"a": f"GO 1\n! {line.made_by!s} \nGO 2\n"}, (line,), places)[0]
    assert cited.moves == (None, None, None)
    assert cited.makers == (NO_SOURCE, line.made_by, line.made_by)
    assert next_move(cited, 1, 1) == 2
    places = [TextPlace("a", 2), TextPlace("b", 1)]
    assert match_lines({"a": "x\nGO 1\n", "b": "GO 2\n"}, (line, line), places)[1].moves == (line,)


def test_a_page_marks_its_line_tints_the_stroke_and_takes_text_for_text():
    line = next(move for move in written().files[0].moves if isinstance(move, Line))
    lines = tuple(f"<{number}>" for number in range(1, 101))
    own = tuple(line if 50 <= number < 60 else None for number in range(1, 101))
    file = TextFile("a", lines, own, tuple(NO_SOURCE if move is None else move.made_by for move in own))
    html = page_html(file, 55, line.made_by)
    numbers = [int(each) for each in re.findall(r"&lt;(\d+)&gt;", html)]
    assert numbers == list(range(49, 49 + PAGE_LINES))
    assert "<55>" not in html
    assert html.count(f"background:{css_colour(CHOSEN_GROUND)}") == 1
    assert html.count(f"background:{GROUND}") == 9
    assert f"background:{GROUND}" not in page_html(file, 55, "")
    ends = [re.findall(r"&lt;(\d+)&gt;", page_html(file, number, "")) for number in (1, 100)]
    assert [(shown[0], shown[-1]) for shown in ends] == [("1", str(PAGE_LINES)), (str(101 - PAGE_LINES), "100")]


def test_the_same_files_are_packed_into_the_same_bytes():
    content = {"main.mod": b"MODULE\n", "b.mod": b"x\n"}
    packed = zip_bytes(content)
    assert packed == zip_bytes(dict(content))
    with zipfile.ZipFile(io.BytesIO(packed)) as archive:
        assert {name: archive.read(name) for name in archive.namelist()} == content


def test_a_motion_is_drawn_with_its_tool_and_nothing_for_nothing():
    line = next(move for move in written().files[0].moves if isinstance(move, Line))
    reach = Reach(line.target, (), "")
    assert motion_glb(None, 0.5) == b""
    assert 0 < len(motion_glb(reach, 0.5)) < len(motion_glb(line, 0.5))


def test_the_text_follows_the_stroke_and_the_stroke_the_text():
    files = written().files
    maker = J1
    session = tiny_session()
    stroke = type("Stroke", (), {"made_by": maker})()
    with small_page(replace(session)) as page:
        scene = SmallScene(page, [stroke])
        preview = TextPreview(page, scene)
        preview.open(files, "")
        assert scene.layers["/motion"] == b""
        assert preview.find(maker)
        index, number = find_text(files, maker)
        assert index == 0
        assert find(page, "Line").value == number
        assert len(scene.layers["/motion"]) > 0
        press(page, "Line", 1)
        assert scene.layers["/motion"] == b""
        press(page, "Line", number)
        assert page.session.selection.made_by == maker
        press(page, "Motion", "Next")
        assert find(page, "Line").value == next_move(files[0], number, 1)
        press(page, "Line", 10**9)
        assert find(page, "Line").value == len(files[0].lines)
        preview.open((), "")
        assert not preview.find(maker)


def test_a_maker_that_was_cut_short_is_the_first_that_begins_so():
    texts = ("sequence[0]/edge", "sequence[0]/around/U1+U2+U3", "sequence[0]/around/U1+U2+U4")
    known = tuple(map(Source.parse, texts))
    lines = ["x", "'sequence[0]/around/U1+...", "y", "1,2,sequence[0]/edge", "(sequence[9]/other)"]
    assert cited_makers(lines, known) == (NO_SOURCE, known[1], known[1], known[0], NO_SOURCE)
