"""An export whose text does something else than planned is refused."""

import re
from collections.abc import Callable
from dataclasses import replace

import pytest
from installations import for_language, small_cell
from robot_programs import PROGRAMS

from programs.errors import ProgramError
from programs.export import export
from programs.motion.lower import lower
from programs.motion.make_motion import make_motion
from programs.posts.proving.proof import prove
from programs.posts.robots.abb import DIALECT

FILE = "tiny.mod"


def refusal(corrupt: Callable[[str], str]) -> str:
    """Why the text is refused after a corruption."""
    cell = small_cell("abb")
    motion = make_motion(PROGRAMS["loop"](), cell)
    files = DIALECT.render(lower(motion, DIALECT.capability), cell)
    text = corrupt(files[FILE])
    assert text != files[FILE]
    with pytest.raises(ProgramError) as caught:
        prove(DIALECT, {**files, FILE: text}, motion, cell)
    place = re.match(rf"{FILE}:(\d+): ", str(caught.value))
    assert place is not None
    line = text.splitlines()[int(place[1]) - 1]
    assert str(caught.value).endswith("Choose another dialect, and report this.")
    return f"{line.strip()} | {caught.value}"


def test_a_wrong_place_names_the_move_and_the_stroke() -> None:
    found = refusal(lambda text: text.replace("p7:=[[0.000,10.000,", "p7:=[[0.000,10.020,"))
    assert found.startswith("TriggL p7,s60,")
    assert "planned at s/pass: the line ends at" in found


def test_a_wrong_pause_names_its_statement() -> None:
    assert refusal(lambda text: text.replace("WaitTime 0.040;", "WaitTime 0.140;")).startswith("WaitTime 0.140; | ")


def test_a_statement_that_cannot_be_read_is_named() -> None:
    found = refusal(lambda text: text.replace("SetGO goMedium,1;", "SetGO goMedium,;"))
    assert found.startswith("SetGO goMedium,; | ")
    assert "The text cannot be read back." in found


def test_an_export_states_how_closely_its_text_does_what_was_planned() -> None:
    done = export(PROGRAMS["in_flight"](), for_language(small_cell(), "abb"), "abb").agreement
    assert done.differences == ()
    assert 0.0 < done.place_mm <= 0.001
    assert 0.0 < done.event_s <= 0.002
    assert done.describe() == (
        f"places within {done.place_mm:.4f} mm and {done.turn_deg:.4f} deg, "
        f"signals within {1e3 * done.event_s:.2f} ms of the plan"
    )


def test_nothing_comes_out_of_a_writer_that_makes_a_mistake(monkeypatch: pytest.MonkeyPatch) -> None:
    def write(*given: object) -> dict[str, str]:
        return {FILE: DIALECT.write(*given)[FILE].replace("SetGO goMedium,1;", "SetGO goMedium,2;")}  # type: ignore[arg-type]

    monkeypatch.setattr("programs.export.DIALECTS", {"abb": replace(DIALECT, write=write)})
    with pytest.raises(ProgramError, match="planned Switch"):
        export(PROGRAMS["loop"](), for_language(small_cell(), "abb"), "abb")
