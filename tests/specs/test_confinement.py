"""What a process that serves a page may read, and what a data file may name."""

import os
from pathlib import Path

import pytest

from specs.confinement import Confinement, admit, confine, find_beside, record_reads, refusal, release, resolve
from specs.errors import LocatedError
from specs.input_file import InputFile
from specs.output_file import OutputError, OutputFile


@pytest.fixture
def place(tmp_path):
    project, outside = tmp_path / "project", tmp_path / "outside"
    (project / "deep").mkdir(parents=True)
    outside.mkdir()
    for file in (project / "a", project / "deep" / "b", outside / "secret", outside / "known"):
        file.write_text("x")
    (project / "link").symlink_to(outside / "secret")
    (project / "way").symlink_to(outside)
    (project / "inner").symlink_to("deep/b")
    (project / "circle").symlink_to("circle")
    return tmp_path


@pytest.fixture
def confined(place):
    confinement = Confinement((resolve(place / "project"),), frozenset({resolve(place / "outside" / "known")}))
    confine(confinement)
    yield place
    release(confinement)


INSIDE = ("project/a", "project/deep/b", "project/inner", "project/deep/../a", "project/missing", "outside/known")
OUTSIDE = (
    "outside/secret", "project/link", "project/way/secret", "project/../outside/secret", "project", "outside/missing",
    "project-too/a", "project/deep/../../outside/secret",
)  # fmt: skip


def test_without_a_page_every_file_is_read(place) -> None:
    for name in (*INSIDE, *OUTSIDE):
        assert refusal(place / name) == ""


@pytest.mark.parametrize("name", INSIDE)
def test_files_of_the_folder_and_known_ones_are_read(confined, name) -> None:
    assert refusal(confined / name) == ""


@pytest.mark.parametrize("name", OUTSIDE[:4] + OUTSIDE[5:])
def test_other_files_are_refused_whether_they_exist_or_not(confined, name) -> None:
    assert refusal(confined / name) == f"is outside the project folder {resolve(confined / 'project')}; copy it there"
    with pytest.raises(LocatedError, match="outside the project folder"):
        InputFile(confined / name, LocatedError, "thing", 10).read()


def test_relative_names_begin_where_the_process_runs(confined, monkeypatch) -> None:
    monkeypatch.chdir(confined / "project")
    assert refusal(type(confined)("a")) == ""
    assert refusal(type(confined)("../outside/secret")) != ""


def test_the_end_of_the_last_page_opens_all_files(confined) -> None:
    second = Confinement((resolve(confined / "outside"),))
    confine(second)
    assert refusal(confined / "outside" / "secret") == ""
    release(second)
    assert refusal(confined / "outside" / "secret") != ""


def test_one_file_is_admitted_for_a_while(confined) -> None:
    with admit(confined / "outside" / "secret"):
        assert refusal(confined / "outside" / "secret") == ""
        assert refusal(confined / "outside" / "missing") != ""
    assert refusal(confined / "outside" / "secret") != ""


def test_what_is_read_is_recorded_with_its_links_resolved(place) -> None:
    with record_reads() as record:
        InputFile(place / "project" / "link", LocatedError, "thing", 10).read()
    InputFile(place / "project" / "a", LocatedError, "thing", 10).read()
    assert record == {resolve(place / "outside" / "secret")}


@pytest.mark.parametrize("name", ["a", "deep/b", "./a", "deep/../a", "inner", "missing", "~", "a b"])
def test_a_data_file_names_files_in_its_folder(place, name) -> None:
    assert find_beside(name, place / "project" / "x.gltf") == place / "project" / name


@pytest.mark.parametrize(
    "name",
    ["", ".", "..", "../outside/secret", "link", "way/secret", "a\0b", "/etc/passwd", "deep/../../outside/secret"],
)
def test_a_data_file_names_nothing_else(place, name) -> None:
    with pytest.raises(ValueError, match=r"name of a file|outside the folder"):
        find_beside(name, place / "project" / "x.gltf")
    with pytest.raises(ValueError, match="outside the folder"):
        find_beside(os.fspath(place / "project" / "a"), place / "project" / "x.gltf")


def test_paths_that_lead_nowhere_stay_as_they_are(place) -> None:
    assert resolve(place / "project" / "circle").name == "circle"
    assert "\0" in str(resolve(place / "a\0b"))


def test_what_was_written_meanwhile_may_be_read_and_written_again_and_what_was_read_before_may_not(
    tmp_path: Path,
) -> None:
    (tmp_path / "read").write_text("a")
    with record_reads():
        InputFile(tmp_path / "read").read()
        for _ in range(2):  # a second attempt is no other
            with pytest.raises(OutputError, match="it is read by this command"):
                OutputFile(tmp_path / "read").write("b")
        for content in ("c", "d"):
            OutputFile(tmp_path / "written").write(content)
            assert InputFile(tmp_path / "written").read() == content.encode()
    assert (tmp_path / "read").read_text() == "a"
