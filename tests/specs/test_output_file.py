"""A file, or a folder of files, is written whole or stays what it was."""

import errno
import io
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from command import contents

from specs.confinement import record_reads
from specs.errors import JobError
from specs.input_file import InputFile
from specs.output_file import PART, OutputError, OutputFile, OutputFolder, write_outputs

ROOT = Path(__file__).parents[2]


def test_the_text_arrives_byte_for_byte_and_nothing_else_stays(tmp_path: Path) -> None:
    file = tmp_path / "a.wash"
    OutputFile(file).write("1 µm\r\n2\n")
    OutputFile(file).write("é\n")
    assert file.read_bytes() == "é\n".encode()
    assert list(tmp_path.iterdir()) == [file]


def test_the_rights_of_a_file_that_is_replaced_are_kept(tmp_path: Path) -> None:
    file = tmp_path / "a"
    file.write_text("old")
    file.chmod(0o640)
    OutputFile(file).write("new")
    assert file.stat().st_mode & 0o777 == 0o640


def test_a_link_is_followed(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "file")
    OutputFile(tmp_path / "link").write(b"new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "file").read_bytes() == b"new"


def test_after_a_failure_the_old_file_still_stands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    file = tmp_path / "a"
    file.write_text("old")
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OutputError, match="No space left"):
        OutputFile(file).write("new")
    assert file.read_text() == "old"
    assert list(tmp_path.iterdir()) == [file]


def test_places_that_cannot_be_written(tmp_path: Path) -> None:
    for place in (tmp_path, tmp_path / "none" / "a", tmp_path / "a\0b"):
        with pytest.raises(OutputError, match="cannot be written"):
            OutputFile(place).write("x")


def test_a_name_that_the_system_refuses_is_an_error_of_writing(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="cannot be written: File name too long"):
        _ = OutputFile(tmp_path / ("n" * 300), beside=(".clock",)).all_written


def test_the_error_says_what_to_do() -> None:
    assert str(OutputError(Path("a"), "it is a folder")) == "a: cannot be written: it is a folder. Name another place."
    assert str(OutputError(Path("a"), "why", "Do this.")).endswith("why. Do this.")


def test_a_file_that_is_written_is_no_failure_where_its_temporary_cannot_be_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(*_: object, **__: object) -> None:
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(Path, "unlink", refused)
    OutputFile(tmp_path / "a").write("new")
    assert contents(tmp_path) == {"a": b"new"}


def test_a_line_of_which_the_system_takes_parts_is_written_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Slow(io.FileIO):
        def write(self, data: Any, /) -> int:
            return super().write(bytes(data)[:5])

    monkeypatch.setattr(io, "FileIO", Slow)
    with OutputFile(tmp_path / "log").lines() as write:
        write("1,not met,home\n")
        write("2,fault,µ\n")
    assert contents(tmp_path) == {"log": "1,not met,home\n2,fault,µ\n".encode()}


def test_a_device_is_written_directly() -> None:
    OutputFile(Path(os.devnull)).write("x")
    assert not Path(os.devnull).is_file()


ONE = {"demo.mod": "MODULE demo\n"}
SOME = {"demo.pgf": "list\n", "demo.mod": "main\n", "demo_01.mod": "part\n"}


def test_one_file_joins_what_is_in_its_folder(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    assert OutputFolder(tmp_path).add(ONE) == [tmp_path / "demo.mod"]
    assert OutputFolder(tmp_path / "made").add(ONE) == [tmp_path / "made" / "demo.mod"]
    assert set(contents(tmp_path)) == {"notes.txt", "demo.mod", "made/demo.mod"}


def test_files_are_written_together_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the last of them cannot be put into its place, those before it are as they were."""
    old, new, last = (OutputFile(tmp_path / name) for name in ("old", "new", "last"))
    old.write("old")
    put = Path.replace

    def refuse(path: Path, target: Path) -> Path:
        if target == last.path:
            raise OSError(errno.EIO, "no")
        return put(path, target)

    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", refuse)
        with pytest.raises(OutputError, match="last: cannot be written: no"):
            write_outputs({old: "1", new: "2", last: "3"})
    assert contents(tmp_path) == {"old": b"old"}
    write_outputs({old: "1", new: "2", last: "3"})
    assert contents(tmp_path) == {"old": b"1", "new": b"2", "last": b"3"}


def test_a_pipe_takes_nothing_where_a_file_cannot_be_made(tmp_path: Path) -> None:
    pipe, folder = OutputFile(tmp_path / "pipe"), OutputFile(tmp_path / "folder")
    os.mkfifo(pipe.path)
    folder.path.mkdir()
    reader = os.open(pipe.path, os.O_RDONLY | os.O_NONBLOCK)
    with pytest.raises(OutputError, match="folder: cannot be written: it is no file"):
        write_outputs({pipe: "1", folder: "2"})
    assert os.read(reader, 9) == b""
    folder.path.rmdir()
    write_outputs({pipe: "1", folder: "2"})
    assert (os.read(reader, 9), folder.path.read_text()) == (b"1", "2")
    os.close(reader)


def test_several_files_make_a_folder_and_replace_their_like(tmp_path: Path) -> None:
    out = tmp_path / "demo"
    longer = {**SOME, "demo_02.mod": "more\n"}
    assert OutputFolder(out).write(longer) == [out / name for name in longer]
    OutputFolder(out).write(SOME)
    assert contents(tmp_path) == {f"demo/{name}": text.encode() for name, text in SOME.items()}


@pytest.mark.parametrize("name", ["thesis.txt", "demo.mod/x", "demo_1.bak"])
def test_a_folder_with_other_things_is_left_alone(tmp_path: Path, name: str) -> None:
    other = tmp_path / name
    other.parent.mkdir(exist_ok=True)
    other.write_text("mine")
    before = contents(tmp_path)
    with pytest.raises(OutputError, match="holds something else"):
        OutputFolder(tmp_path).write(SOME)
    assert contents(tmp_path) == before


def test_a_folder_for_a_set_is_refused_before_the_work_if_it_holds_something_else(tmp_path: Path) -> None:
    folder = OutputFolder(tmp_path, r".*\.mod|front-\d+\.yaml")
    folder.check()
    for name in ("a.MOD", "front-12.yaml", ".washboard-1-0123456789abcdef.tmp"):
        (tmp_path / name).write_text("")
    folder.check()
    (tmp_path / "notes.yaml").mkdir()
    OutputFolder(tmp_path).check()
    with pytest.raises(OutputError, match=r"holds something else, notes\.yaml"):
        folder.check()


def test_several_files_do_not_go_into_a_file_or_into_nowhere(tmp_path: Path) -> None:
    file = tmp_path / "demo"
    file.write_text("mine")
    with pytest.raises(OutputError, match="Name a folder"):
        OutputFolder(file).write(SOME)
    with pytest.raises(OutputError, match="Name a folder"):
        OutputFolder(file).add(ONE)
    with pytest.raises(OutputError, match="cannot be written"):
        OutputFolder(file / "where").write(SOME)
    assert contents(tmp_path) == {"demo": b"mine"}


def test_after_a_failure_the_old_files_stand(tmp_path: Path) -> None:
    out = tmp_path / "demo"
    OutputFolder(out).write(SOME)
    before = contents(tmp_path)
    with pytest.raises(OutputError):
        OutputFolder(out).write({**SOME, "no/demo_03.mod": ""})
    assert contents(tmp_path) == before


def test_a_folder_is_one_processs_at_a_time(tmp_path: Path) -> None:
    folder = OutputFolder(tmp_path)
    with folder.locked(), pytest.raises(OutputError, match="cannot be written: another process uses it"):
        folder.locked().__enter__()
    with folder.locked():
        pass


@pytest.mark.parametrize("call", ["io.FileIO", "fcntl.flock", "os.ftruncate", "os.fsync"])
def test_a_log_or_a_folder_that_the_system_refuses_is_named(
    call: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    monkeypatch.setattr(f"specs.output_file.{call}", refuse)
    with (
        pytest.raises(OutputError, match=r"a\.csv(\.part)?: cannot be written: Input/output error"),
        OutputFile(tmp_path / "a.csv").lines(),
    ):
        pass
    if call == "fcntl.flock":
        with pytest.raises(OutputError, match="cannot be written: Input/output"), OutputFolder(tmp_path).locked():
            pass


@pytest.mark.parametrize("number", [errno.EIO, errno.EOPNOTSUPP])
def test_a_file_that_cannot_be_locked_is_written_only_where_nothing_can_be(
    number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr("fcntl.flock", refuse)
    if number == errno.EIO:  # the next writing of this run may lock it again, and would take it for nobody's
        with pytest.raises(OutputError, match=r"a\.csv: cannot be written: Input/output error"):
            OutputFile(tmp_path / "a.csv").write("text")
    else:
        OutputFile(tmp_path / "a.csv").write("text")
    assert contents(tmp_path) == ({} if number == errno.EIO else {"a.csv": b"text"})


def test_a_line_that_cannot_be_written_names_its_file() -> None:
    refused = pytest.raises(OutputError, match=r"^/dev/full: cannot be written: No space left on device")
    with refused, OutputFile(Path("/dev/full")).lines() as add:
        add("a line")
    with pytest.raises(OSError, match="of another cause"), OutputFile(Path("/dev/null")).lines():
        raise OSError("of another cause")


def test_lines_behind_a_link_grow_beside_what_it_leads_to(tmp_path: Path) -> None:
    """A folder of another file system takes no rename from here."""
    far = tmp_path / "far"
    far.mkdir()
    (tmp_path / "log.csv").symlink_to(far / "real.csv")
    output = OutputFile(tmp_path / "log.csv", "", (PART,))
    assert [each.path for each in output.all_written[1:]] == [far / "real.csv.part"]
    with output.lines() as add:
        add("one\n")
        assert contents(far) == {"real.csv.part": b"one\n"}
    assert contents(far) == {"real.csv": b"one\n"}
    assert [each.name for each in tmp_path.iterdir() if not each.is_dir()] == ["log.csv"]


def test_a_link_into_no_folder_names_that(tmp_path: Path) -> None:
    (tmp_path / "log.csv").symlink_to(tmp_path / "gone" / "real.csv")
    with pytest.raises(OutputError, match=rf"there is no folder {tmp_path}/gone"):
        OutputFile(tmp_path / "log.csv").check()


WRITES = """
import sys
from pathlib import Path
from specs.output_file import OutputFile
print("first")
OutputFile(Path(sys.argv[1])).write("text\\n")
with OutputFile(Path(sys.argv[1])).lines() as add:
    add("line\\n")
print("last")
"""


@pytest.mark.parametrize("name", ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1", "link"])
@pytest.mark.parametrize("mode", ["a", "w"])
def test_a_file_that_stdout_is_turned_to_keeps_what_is_in_it(name: str, mode: str, tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to("/dev/stdout")
    out = tmp_path / "out.txt"
    out.write_text("before\n")
    with out.open(mode) as stdout:
        words = [sys.executable, "-c", WRITES, tmp_path / name if name == "link" else name]
        subprocess.run(words, stdout=stdout, check=True, cwd=ROOT)
    expected = "first\ntext\nline\nlast\n"
    assert out.read_text() == ("before\n" if mode == "a" else "") + expected
    assert sorted(each.name for each in tmp_path.iterdir()) == ["link", "out.txt"]


def test_a_folder_of_another_user_is_not_made_private(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    OutputFolder(tmp_path / "own" / "live").make(private=True)
    monkeypatch.setattr("os.geteuid", lambda: os.getuid() + 1)
    with pytest.raises(OutputError, match="another user owns"):
        OutputFolder(tmp_path / "own" / "live").make(private=True)


def test_a_set_leaves_files_of_another_program_alone(tmp_path: Path) -> None:
    second = {"rev2__wash.src": "a", "rev2__wash.dat": "b", "rev2__wash.src.commissioning.md": "c"}
    OutputFolder(tmp_path / "out").write(second)
    with pytest.raises(OutputError, match="holds something else, rev2__wash"):
        OutputFolder(tmp_path / "out").write({name.replace("rev2", "rev1"): text for name, text in second.items()})
    longer = {"w1.src": "", "w1_1.src": "", "w1_12.src": ""}
    OutputFolder(tmp_path / "long").write(longer)
    with pytest.raises(OutputError, match="holds something else"):
        OutputFolder(tmp_path / "long").write({"w2.src": "", "w2_1.src": ""})
    OutputFolder(tmp_path / "long").write({"w1.src": "", "w1_1.src": ""})
    assert {*contents(tmp_path / "long")} == {"w1.src", "w1_1.src"}


def test_a_set_keeps_the_modes_of_what_it_replaces(tmp_path: Path) -> None:
    folder = OutputFolder(tmp_path / "out")
    folder.write(SOME)
    folder.path.chmod(0o2770)
    (folder.path / "demo.mod").chmod(0o600)
    folder.write({**SOME, "demo_02.mod": ""})
    assert (folder.path.stat().st_mode & 0o7777, (folder.path / "demo.mod").stat().st_mode & 0o777) == (0o2770, 0o600)


def test_results_are_written_all_or_none(tmp_path: Path) -> None:
    old, other = OutputFile(tmp_path / "old"), OutputFile(tmp_path / "other")
    old.write("before")
    with pytest.raises(OutputError, match="/dev/full"):
        write_outputs({old: "now", OutputFile(Path("/dev/full")): "lost", other: "now"})
    other.path.write_text("read")
    with record_reads():
        InputFile(other.path).read()
        with pytest.raises(OutputError, match="other: cannot be written: it is read"):
            write_outputs({old: "now", other: "now"})
    assert (old.path.read_text(), other.path.read_text()) == ("before", "read")
    write_outputs({old: "now", other: "now", None: "nowhere"})
    assert (old.path.read_text(), other.path.read_text()) == ("now", "now")


def test_an_output_that_an_input_names_is_refused_where_it_is_read(tmp_path: Path) -> None:
    named = tmp_path / "base.yaml"
    named.write_text("a: 1")
    (tmp_path / "link").symlink_to(named)
    with record_reads(written=[tmp_path / "link"]), pytest.raises(JobError, match="is to be written by this command"):
        InputFile(named).read()
    with record_reads(named, written=[named]):  # it is edited in its place
        assert InputFile(named).read() == b"a: 1"


def test_what_this_process_has_opened_for_itself_is_no_output() -> None:
    reader, writer = os.pipe()
    with pytest.raises(OutputError, match="none that the command was started with"):
        OutputFile(Path(f"/dev/fd/{writer}")).check()
    os.set_inheritable(writer, True)  # as what a shell has opened
    OutputFile(Path(f"/dev/fd/{writer}")).write("x")
    assert os.read(reader, 9) == b"x"
    os.close(reader)
    os.close(writer)
