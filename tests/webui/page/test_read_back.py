"""Programs in robots' languages are rebuilt for the page; hostile ones are refused, and nothing is lost."""

import io
import zipfile
import zlib
from functools import cache

import numpy as np
import pytest
from installations import for_language
from robot_programs import joints_of
from tiny_session import tiny_session

from programs.errors import ProgramError
from programs.export import export
from programs.plan import SprayPass
from programs.posts.dialects import DIALECTS
from robotcell.cell.installation import installation_of
from robotcell.cell.load import read_cell
from specs.confinement import Confinement, confine, release
from specs.errors import JobError
from webui.layers.paths.strokes import stroke_lines
from webui.page.project import library_folders, open_project
from webui.page.read_back import read_project_program, read_uploaded_program, unpack


def quiet(_what, _done):
    pass


@cache
def exported(dialect):
    program = tiny_session().run.program
    installation = for_language(installation_of(read_cell("ur5e-bench")), dialect)
    joints = joints_of(program) if DIALECTS[dialect].needs_joints else None
    return export(program, installation, dialect, joints).files


@pytest.fixture
def project(tmp_path):
    (tmp_path / "project").mkdir()
    return open_project(tmp_path / "project")


@pytest.fixture(autouse=True)
def confined(project):
    """As where a page is served: nothing but the project folder and the libraries is read."""
    own = Confinement((project.folder, *library_folders()))
    confine(own)
    yield
    release(own)


def zip_of(files):
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            archive.writestr(name, text)
    return packed.getvalue()


def upload(project, name, content):
    return read_uploaded_program(project, name, content, tiny_session(), quiet)


@pytest.mark.parametrize("dialect", ["abb", pytest.param("kuka", marks=pytest.mark.slow)])
def test_a_program_of_the_folder_and_an_upload_are_the_same(dialect, project):
    files = exported(dialect)
    (project.folder / "out").mkdir()
    for name, text in files.items():
        (project.folder / "out" / name).write_text(text)
    assert {"out/", *(f"out/{name}" for name in files)} == set(project.programs())
    opened = read_project_program(project, "out/", tiny_session(), quiet)
    packed = upload(project, "out.zip", zip_of({f"deep/{name}": text for name, text in files.items()}))
    assert packed.run.program == opened.run.program
    assert (opened.cell, opened.workpiece_name, opened.note) == ("ur5e-bench", "tiny", "")
    assert not [each for each in project.folder.iterdir() if each.name != "out"]


def test_paths_are_those_that_the_jet_sprays(project):
    ((name, text),) = exported("abb").items()
    planned, read = tiny_session().run, upload(project, name, text.encode())
    passes = [item for item in read.run.plan.items if isinstance(item, SprayPass)]
    assert len(passes) == sum(getattr(item, "spraying", False) for item in read.run.program.instructions)
    drawn, own = stroke_lines(read.run.plan), stroke_lines(planned.plan)
    assert sum(each.length_mm for each in drawn) == pytest.approx(sum(each.length_mm for each in own), rel=0.1)
    for corner in (np.min, np.max):
        ends = [corner(np.concatenate([each.points for each in lines]), axis=0) for lines in (drawn, own)]
        np.testing.assert_allclose(*ends, atol=1.0)
    commands = [item for item in read.run.program.instructions if getattr(item, "keyword", "") == "NOZZLE"]
    assert {item.arguments[0] for item in commands} & set(read.run.recipe.nozzles)


@pytest.mark.parametrize(
    ("name", "change", "reason"),
    [
        ("a.mod", lambda text: text.replace("MoveL p1", "MoveC p1", 1), r"^a\.mod:\d+: unknown statement 'MoveC p1"),
        ("a.mod", lambda text: "\xe9" + text, r"^a\.mod:1: this is not the ASCII text"),
        (
            "a.mod",
            lambda text: text.replace("Cell ", "Cell other-"),
            "made for cell .*; choose its cell in the tab Robot",
        ),
        ("a.mod", lambda text: "", "a.mod"),
        ("a.exe", lambda text: text, "no program in a robot's language"),
        ("../a.mod", lambda text: text, "cannot be kept"),
        ("a.zip", lambda text: text, "cannot be unpacked"),
    ],
)
def test_what_is_no_program_is_refused_with_its_own_name(name, change, reason, project):
    (text,) = exported("abb").values()
    with pytest.raises(JobError, match=reason) as caught:
        upload(project, name, change(text).encode("latin-1"))
    assert "/tmp" not in str(caught.value).replace(str(project.folder), "")
    assert not list(project.folder.iterdir())


def test_nothing_outside_the_folder_is_read(project):
    ((name, text),) = exported("abb").items()
    outside = project.folder.parent / name
    outside.write_text(text)
    (project.folder / "linked").mkdir()
    (project.folder / "linked" / name).symlink_to(outside)
    (project.folder / "away").symlink_to(project.folder.parent)
    around = tiny_session()
    up, below = (f"../{name}", "../", str(outside), "/"), (f"away/{name}", "away/", f"linked/{name}", "linked/")
    for wanted in (*up, *below, "./.x/", "no/"):
        with pytest.raises(JobError):
            read_project_program(project, wanted, around, quiet)
    assert project.programs() == []


@pytest.mark.slow
def test_a_zip_that_unpacks_without_end_is_refused(project):
    bomb = zip_of({"a.mod": b"0" * 60_000_000})
    assert len(bomb) < 100_000
    with pytest.raises(ProgramError, match="unpacks to more than"):
        unpack("a.zip", bomb)
    with pytest.raises(ProgramError, match="too many for one program"):
        unpack("a.zip", zip_of({f"{number}.mod": "" for number in range(600)}))
    with pytest.raises(ProgramError, match=r"several files a\.mod"):
        unpack("a.zip", zip_of({"x/a.mod": "1", "y/a.mod": "2"}))
    with pytest.raises(JobError, match="no program in a robot's language in this zip"):
        unpack("a.zip", zip_of({"readme.md": "1"}))
    damaged = bytearray(zip_of({"a.mod": "text " * 500}))
    damaged[40:60] = zlib.compress(b"noise")[:20].ljust(20, b"x")
    with pytest.raises(ProgramError, match="cannot be unpacked"):
        unpack("a.zip", bytes(damaged))
    assert set(unpack("a.zip", zip_of({"../../../etc/a.mod": "1", "C:\\b.pgf": "2"}))) == {"a.mod", "b.pgf"}
