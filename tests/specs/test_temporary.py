"""Temporaries of processes that were killed are removed; nothing else is."""

import errno
import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from command import contents

from specs.errors import JobError
from specs.output_file import OutputFile, OutputFolder
from specs.temporary import REPLACED, sweep, temporary_file, temporary_folder, write_temporary

DEAD = ".washboard-1-0123456789abcdef.tmp"
HOLD = """
import os, sys
from pathlib import Path
from specs.temporary import temporary_file, temporary_folder
with {block} as made:
    print("ready", flush=True)
    sys.stdin.read()
"""


def test_no_place_for_temporary_files_at_all_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", None)
    for name in ("TMPDIR", "TEMP", "TMP"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(tempfile, "_candidate_tempdir_list", lambda: ["/proc/none"])
    with pytest.raises(JobError, match=r"no folder takes temporary files .*: name one in TMPDIR"), temporary_folder():
        pass


def holder(block: str) -> subprocess.Popen[str]:
    """A process of its own that holds a temporary until its stdin ends."""
    process = subprocess.Popen(
        [sys.executable, "-c", HOLD.format(block=block)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    return process


@pytest.mark.parametrize("kind", ["temporary_file", "temporary_folder"])
def test_a_temporary_lives_as_long_as_its_process_and_goes_with_the_next_writing(kind: str, tmp_path: Path) -> None:
    with holder(f"{kind}(Path({str(tmp_path)!r}))") as process:
        held = sorted(tmp_path.iterdir())
        sweep(tmp_path)
        OutputFile(tmp_path / "a").write(b"1")
        assert sorted(tmp_path.iterdir()) == [*held, tmp_path / "a"]
        process.send_signal(signal.SIGKILL)
        process.wait()
    assert sorted(tmp_path.iterdir()) == [*held, tmp_path / "a"]
    OutputFile(tmp_path / "a").write(b"2")
    assert list(tmp_path.iterdir()) == [tmp_path / "a"]


def test_a_stopped_process_keeps_its_temporary(tmp_path: Path) -> None:
    with holder(f"temporary_file(Path({str(tmp_path)!r}))") as process:
        process.send_signal(signal.SIGSTOP)
        sweep(tmp_path)
        assert len(list(tmp_path.iterdir())) == 1
        process.send_signal(signal.SIGCONT)
        process.communicate()
    assert process.returncode == 0
    assert list(tmp_path.iterdir()) == []


def test_two_writers_beside_each_other_do_not_disturb(tmp_path: Path) -> None:
    with temporary_file(tmp_path) as (one, first), temporary_folder(tmp_path) as folder:
        with temporary_file(tmp_path) as (other, _):
            assert one != other
            os.write(first, b"kept")
        sweep(tmp_path)
        assert one.read_bytes() == b"kept"
        assert folder.is_dir()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["a.tmp", ".a.123.tmp", DEAD + ".bak", DEAD.replace("-1-", "-x-"), DEAD + ".d"])
def test_what_has_another_name_stays(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text("mine")
    sweep(tmp_path)
    assert (tmp_path / name).read_text() == "mine"


def test_links_folders_and_pipes_of_such_a_name_stay_and_are_not_followed(tmp_path: Path) -> None:
    inside = tmp_path / "inside"
    inside.mkdir()
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "thesis").write_text("all of it")
    (inside / DEAD).symlink_to(mine / "thesis")
    (inside / DEAD.replace("-1-", "-2-")).mkdir()
    os.mkfifo(inside / DEAD.replace("-1-", "-3-"))
    (inside / DEAD.replace("-1-", "-4-")).write_bytes(b"")
    (inside / (DEAD.replace("-1-", "-4-") + ".d")).symlink_to(mine)
    sweep(inside)
    assert (mine / "thesis").read_text() == "all of it"
    left = sorted(each.name.split("-")[1] for each in inside.iterdir() if not each.name.endswith(".d"))
    assert left == ["1", "2", "3"]


def test_a_folder_that_was_moved_away_is_put_back(tmp_path: Path) -> None:
    (tmp_path / DEAD).write_bytes(b"robot")
    kept = tmp_path / (DEAD + ".d") / REPLACED
    kept.mkdir(parents=True)
    (kept / "a.mod").write_text("old")
    sweep(tmp_path)
    assert [each.name for each in tmp_path.iterdir()] == ["robot"]
    assert (tmp_path / "robot" / "a.mod").read_text() == "old"


def test_litter_inside_a_folder_of_programs_does_not_make_it_a_strangers(tmp_path: Path) -> None:
    files = {"a.mod": "1\n", "a_01.mod": "2\n"}
    OutputFolder(tmp_path / "robot").write(files)
    (tmp_path / "robot" / DEAD).write_bytes(b"")
    OutputFolder(tmp_path / "robot").write(files)
    assert sorted(each.name for each in (tmp_path / "robot").iterdir()) == ["a.mod", "a_01.mod"]


def test_a_name_of_the_greatest_length_can_be_written(tmp_path: Path) -> None:
    OutputFile(tmp_path / ("ü" * 127)).write(b"x")
    assert [each.name for each in tmp_path.iterdir()] == ["ü" * 127]


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT])
def test_a_full_place_for_temporary_files_is_named(
    number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    full = rf"the folder for temporary files, {tmp_path}, is full. Free some space, or name another one"
    with pytest.raises(JobError, match=full), temporary_folder():
        raise OSError(number, "no space")
    with pytest.raises(OSError, match="elsewhere"), temporary_folder(tmp_path):
        raise OSError(number, "elsewhere")
    with pytest.raises(PermissionError), temporary_folder():
        raise PermissionError(errno.EACCES, "another reason")
    assert contents(tmp_path) == {}


def test_a_place_for_temporary_files_that_cannot_be_used_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def damaged(path: Path, _: bytes) -> None:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(Path, "write_bytes", damaged)
    unusable = rf"the folder for temporary files, {tmp_path}, cannot be used: Input/output error\. Repair that, or"
    with pytest.raises(JobError, match=unusable), temporary_folder() as folder:
        write_temporary(folder, "a", b"content")
    assert contents(tmp_path) == {}
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "none"))
    with pytest.raises(JobError, match="cannot be used: No such file or directory"), temporary_folder():
        pass
