import io
import re
import zipfile
from dataclasses import replace

import pytest
from small_page import find, press, small_page
from small_scene import SmallScene
from tiny_session import tiny_session

from programs.errors import ProgramError
from programs.motion import Line, Reach
from programs.posts.dialects import DIALECTS
from robotcell.installing import installation_of
from robotcell.load import read_cell
from webui.layers.motion_mark import motion_glb
from webui.panels.text_preview import TextPreview
from webui.program_text import (
    PAGE_LINES,
    TextFile,
    find_text,
    match_lines,
    next_move,
    page_html,
    write_program,
    zip_bytes,
)


def written(dialect="abb"):
    installation = installation_of(read_cell("ur5e-bench"))
    return write_program(tiny_session().run.program, installation, dialect, None)


@pytest.mark.parametrize("dialect", [name for name, each in DIALECTS.items() if not each.needs_joints])
def test_text_and_place_belong_together(dialect):
    """Where the text states coordinates, they are those of the place; the reader judges the order."""
    done = written(dialect)
    if not done.tells_places:
        pytest.skip(f"{dialect} does not say yet how its motions are told")
    moves = [move for file in done.files for move in file.moves if move is not None]
    read = [step.target for step in DIALECTS[dialect].read(done.content).steps if hasattr(step, "target")]
    assert len(moves) == len(read)
    for move, target in zip(moves, read, strict=True):
        assert move.target.position == pytest.approx(target.position, abs=0.02)


def test_every_stroke_of_the_plan_is_found_in_the_text_and_leads_back():
    done, session = written(), tiny_session()
    makers = {item.made_by for item in session.run.plan.items if hasattr(item, "jet") and hasattr(item, "tcp")}
    assert len(makers) > 5
    for made_by in makers:
        index, number = find_text(done.files, made_by)
        assert done.files[index].moves[number - 1].made_by == made_by
        assert find_text(done.files[:index], made_by) is None
    assert find_text(done.files, "nobody") is None


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
    pattern = re.compile("GO")
    assert match_lines({"a": "GO 1\nGO 2\n"}, (line,), pattern)[0].moves == (None, None)
    assert match_lines({"a": "x\nGO 1\n", "b": "GO 2\n"}, (line, line), pattern)[1].moves == (line,)


def test_a_page_marks_its_line_tints_the_stroke_and_takes_text_for_text():
    line = next(move for move in written().files[0].moves if isinstance(move, Line))
    lines = tuple(f"<{number}>" for number in range(1, 101))
    file = TextFile("a", lines, tuple(line if 50 <= number < 60 else None for number in range(1, 101)))
    html = page_html(file, 55, line.made_by)
    numbers = [int(each) for each in re.findall(r"&lt;(\d+)&gt;", html)]
    assert numbers == list(range(PAGE_LINES + 1, 2 * PAGE_LINES + 1))
    assert "<55>" not in html
    assert html.count("#f6d9d1") == 1
    assert html.count("#fbf1ee") == 9
    assert "#fbf1ee" not in page_html(file, 55, "")


def test_the_same_files_are_packed_into_the_same_bytes():
    content = {"main.mod": "MODULE\n", "b.mod": "x\n"}
    packed = zip_bytes(content)
    assert packed == zip_bytes(dict(content))
    with zipfile.ZipFile(io.BytesIO(packed)) as archive:
        assert {name: archive.read(name).decode() for name in archive.namelist()} == content


def test_a_language_that_there_is_not_is_refused():
    with pytest.raises(ProgramError, match="no dialect"):
        written("klingon")


def test_a_motion_is_drawn_with_its_tool_and_nothing_for_nothing():
    line = next(move for move in written().files[0].moves if isinstance(move, Line))
    reach = Reach(line.target, (), "")
    assert motion_glb(None, 0.5) == b""
    assert 0 < len(motion_glb(reach, 0.5)) < len(motion_glb(line, 0.5))


def test_the_text_follows_the_stroke_and_the_stroke_the_text():
    files = written().files
    maker = "sequence[0]/around/J1"
    session = tiny_session()
    stroke = type("Stroke", (), {"made_by": maker})()
    with small_page(replace(session)) as page:
        scene = SmallScene(page, [stroke])
        preview = TextPreview(page, scene)
        page._panels = []
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
