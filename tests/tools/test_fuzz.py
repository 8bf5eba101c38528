"""Every reader and every parameter has mutated inputs made for it, and a slice of them finds no fault."""

import ast
import os
import re
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Annotated

import fuzz
import pytest
import typer
from audited import WORDS
from fuzzing import targets
from fuzzing.worker import cases_of

from boards.formats.table import FORMATS, Format
from commandline.arguments import input_option
from programs.posts.dialects import DIALECTS
from specs.errors import JobError
from specs.input_file import InputFile

ROOT = Path(__file__).parents[2]
NAMES = {word: b"" for words in WORDS.values() for word in words if "." in word} | {
    "cell.yaml": b"",
    "drive.csv": b"",
    "TINY__SMT_AQUEOUS.h": b"",
}
OPEN_NO_INPUT = {
    "boards/formats/archive.py:_in_folder.<locals>.below": "what it yields is read where it is needed",
    "boards/formats/kicad/imported.py:import_board": "where KiCad is installed; its tests have a stand-in",
    "boards/formats/table.py:is_marked": "the beginning of a file, of which kind it is",
    "boards/load.py:is_panel_file": "the beginning of a file, of which kind it is",
    "boards/part/sources.py:is_part_source": "the beginning of a file, of which kind it is",
    "boards/parts_table/read.py:read_table": "an order gives it the content",
    "commandline/arguments.py:input_name": "looks whether it is a file",
    "reports/files/tuning_state.py:check_output": "its own output",
    "specs/temporary.py:read_temporary": "what a library wrote for it",
    "studies/store.py:ResultStore.read": "its own results; any other is computed anew",
    "washboard/cleaned.py:analyse": "the program that was read, for its fingerprint",
    "webui/downloads/downloads.py:_everything": "the cell that was read, for a download",
    "webui/live/live.py:_read": "its own announcement",
    "webui/page/project.py:Project._head": "the beginnings of files, to list them",
}


def test_every_reader_and_every_parameter_has_cases() -> None:
    every = targets.make_targets(NAMES)
    assert targets.lacking(every) == []
    assert len(every) == len([*targets.parameters()]) + len(FORMATS) + len(targets.DIALECTS) + len(
        targets.file_kinds()
    ) + len(targets.READERS)


def test_a_parameter_of_ones_own_without_a_generator_is_named() -> None:
    app = typer.Typer()

    @app.command()
    def sing(
        song: Annotated[str, typer.Option("--song")] = "",
        voice: Annotated[str, input_option("--voice", "WAV", "A voice.")] = "",
        verses: Annotated[int, typer.Option("--verses")] = 1,
    ) -> None:
        """Nothing in the audit or the corpus knows of it."""

    @app.command()
    def dance() -> None:
        """A second one: of a single command the words have no name."""

    found = targets.make_targets(NAMES, app)
    assert targets.lacking(found) == ["sing --song", "sing --voice"]


def test_a_format_and_a_language_of_ones_own_without_files_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(targets, "FORMATS", (*FORMATS, Format("Clay", (".clay",), "formats.scene:read_scene")))
    monkeypatch.setattr(targets, "DIALECTS", {**targets.DIALECTS, "latin": targets.DIALECTS["abb"]})
    assert targets.lacking(targets.make_targets(NAMES)) == ["Clay", "latin"]


def raises(path: Path) -> None:
    raise ZeroDivisionError(path)


def refuses_namelessly(path: Path) -> None:
    raise JobError("something is wrong")


def refuses_in_words_of_a_library(path: Path) -> None:
    raise JobError(f"{path}: ValueError: array([1])")


def prints(path: Path) -> None:
    os.write(2, b"a warning")


def ends(path: Path) -> None:
    os._exit(3)


def refuses(path: Path) -> None:
    quoted = re.findall("LinkError", path.read_text("utf-8", "replace"))
    raise JobError(f"{path}: {quoted} is in it; give another file")


def writes_elsewhere(path: Path) -> None:
    path.parents[2].joinpath("litter").write_text("")


@pytest.mark.parametrize(
    ("read", "message"),
    [
        (raises, "ZeroDivisionError in test_fuzz.py"), (refuses_namelessly, "the file is not named"),
        (refuses_in_words_of_a_library, "a library's words"), (prints, "printed b'a warning'"),
        (ends, "ended its process: exit 3"), (writes_elsewhere, "PermissionError"), (refuses, ""),
    ],
)  # fmt: skip
def test_what_is_no_clear_refusal_is_a_fault(read: Callable[[Path], None], message: str) -> None:
    target = targets.Target("x", (targets.Case({"a.txt": b"1 2 3 LinkError"}),), read)
    found = [*fuzz.outcomes(target, {}, lambda at, pool: cases_of(target, 1, range(at, 3), pool), range(1, 3))]
    assert [each.number for each in found] == [1, 2]
    assert {each.verdict for each in found} == {"fault" if message else "refused"}
    assert [each.message for each in found if message not in each.message] == []


@pytest.mark.slow
@pytest.mark.parametrize("language", DIALECTS)
@pytest.mark.parametrize("digits", [200, 5000])
def test_a_number_that_no_robot_knows_is_read_or_refused(
    language: str, digits: int, tmp_path: Path, recwarn: pytest.WarningsRecorder
) -> None:
    """The last number of a statement of each form; 200 digits square to infinity, 5000 are infinite and no int."""
    target = next(each for each in targets._languages() if each.name == language)
    files, forms = target.seeds[0].files, set[str]()
    for name, content in files.items():
        lines = content.decode().splitlines(keepends=True)
        for at, line in enumerate(lines):
            number, form = re.search(r"\d+(?=\D*$)", line), re.sub(r"\d+", "9", line)
            if number is not None and form not in forms:
                forms.add(form)
                changed = line[: number.start()] + "9" * digits + line[number.end() :]
                text = "".join([*lines[:at], changed, *lines[at + 1 :]])
                with suppress(JobError):
                    target.run(targets.Case({**files, name: text.encode()}), tmp_path)
    assert len(forms) > 10
    assert [str(each.message) for each in recwarn] == []


@pytest.mark.parametrize(
    ("text", "is_opener"),
    [
        ("InputFile(p).read()", True), ("import specs.input_file as i\ni.InputFile(p)", True),
        ("from specs.input_file import InputFile as Door\nDoor(p)", True), ("door = InputFile\ndoor(p)", True),
        ("partial(InputFile, noun='table')(p)", True), ("map(InputFile, paths)", True),
        ("def read(file: InputFile) -> bytes:\n    return file.read()", False), ("isinstance(x, str)", False),
    ],
)  # fmt: skip
def test_an_input_is_opened_under_whatever_name(text: str, is_opener: bool) -> None:
    assert bool(targets.opens(ast.parse(text))) is is_opener


@pytest.mark.slow
def test_every_function_that_opens_an_input_is_reached_by_a_valid_one(monkeypatch: pytest.MonkeyPatch) -> None:
    reached: set[str] = set()
    begin = InputFile.__init__

    def recorded(self: InputFile, *words: object, **named: object) -> None:
        for frame in (sys._getframe(1), sys._getframe(2)):  # what opens it, or what calls one that does nothing else
            code = frame.f_code
            if code.co_filename.startswith(str(ROOT)):
                name = re.sub(r"(\.<locals>)?\.<(genexpr|\w+comp|lambda)>", "", code.co_qualname)
                reached.add(f"{Path(code.co_filename).relative_to(ROOT).as_posix()}:{name}")
        begin(self, *words, **named)  # type: ignore[arg-type]

    monkeypatch.setattr(InputFile, "__init__", recorded)
    every = {name: targets.with_valid_seeds(each) for name, each in targets.make_targets(NAMES).items()}
    assert targets.lacking(every) == []
    assert sorted(targets.openers() - reached) == sorted(OPEN_NO_INPUT)


@pytest.mark.slow
@pytest.mark.long
def test_a_slice_of_the_fuzz_finds_no_fault() -> None:
    readers = [name for name, target in targets.make_targets(NAMES).items() if target.read is not None]
    some = [*readers, "plan *", "cell edit *"]
    words = [sys.executable, ROOT / "tools" / "fuzz.py", "--cases", "120", "--seed", "5", "--only", ",".join(some)]
    run = subprocess.run(words, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
    rows = re.findall(r"^(\S.*?) +(\d+) +(\d+) +(\d+) ", run.stdout, re.MULTILINE)
    assert sum(int(row[1]) for row in rows if row[0] != "target") >= 120
    assert all(int(refused) + int(accepted) == int(cases) for _, cases, refused, accepted in rows)
