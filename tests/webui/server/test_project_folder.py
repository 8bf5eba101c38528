"""Nothing outside the project folder is read through the page: by names that it sends, or that files state."""

import base64
import itertools
import json
import os
import re
from functools import partial
from html import unescape
from pathlib import Path

import pytest
from bare_client import BarePage, answer, bare_page, cookie_of
from opened_files import opened_below
from small_cells import CELL

from boards.load import board_library
from recipes.load import recipe_library
from webui.page.project import open_project
from webui.server.server import open_session, serve

RECIPE = recipe_library()["rinse-only"].read_text()
SECRET = RECIPE.replace("rinse-only", "secret")
IDF_HEAD = '.HEADER\n{kind} 3.0 "x" 2020/01/01.00:00:00 1\n{rest}.END_HEADER\n'
URDF = """<robot name="two"><link name="foot"><collision><geometry><mesh filename="{mesh}"/></geometry></collision>
</link><link name="hand"/><joint name="S" type="prismatic"><parent link="foot"/><child link="hand"/><axis xyz="0 0 1"/>
<limit lower="-0.1" upper="0.2" velocity="0.5"/></joint></robot>"""
TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


class Place:
    """A project folder, and secrets around it that a page must not reach."""

    def __init__(self, around: Path) -> None:
        self.folder, self.outside = around / "project", around / "outside"
        self.folder.mkdir()
        self.outside.mkdir()
        (self.folder / "deep").mkdir()
        (self.outside / "secret.yaml").write_text(SECRET)
        (self.outside / "cell.yaml").write_text(CELL)
        (self.outside / "robot").write_text("robot: x\n")
        (self.outside / "robot.urdf").write_text(URDF.format(mesh="m.obj"))
        (self.outside / "secret.bin").write_bytes(bytes(1000))
        (self.outside / "m.obj").write_text(TRIANGLE)
        (self.outside / "library.emp").write_text(IDF_HEAD.format(kind="LIBRARY_FILE", rest=""))
        (self.outside / "parameters.yaml").write_text("parameters: secret\nextends: default\n")
        (self.outside / "secret.tri").write_bytes(board_library()["tiny"].read_bytes())
        (around / "m.obj").write_text(TRIANGLE)
        (self.folder / "here.yaml").write_text(RECIPE.replace("recipe: rinse-only", "recipe: here"))
        for suffix in ("yaml", "tri"):
            (self.folder / f"link.{suffix}").symlink_to(self.outside / f"secret.{suffix}")
            (self.folder / f"null.{suffix}").symlink_to("/dev/null")
            (self.folder / f"circle.{suffix}").symlink_to(f"circle.{suffix}")
            os.mkfifo(self.folder / f"pipe.{suffix}")
        (self.folder / "way").symlink_to(self.outside)
        (self.folder / ".hidden.yaml").write_text(SECRET)

    def files(self) -> dict[str, bytes]:
        around = self.folder.parent
        found = (path for path in around.rglob("*") if path.is_file() and ".washboard" not in path.parts)
        return {str(path.relative_to(around)): path.read_bytes() for path in found if not path.is_symlink()}


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return Place(tmp_path_factory.mktemp("around"))


@pytest.fixture(scope="module")
def page(place):
    server = serve(open_session("tiny", "rinse-only"), open_project(place.folder), "127.0.0.1", 0)
    with bare_page(server) as page:
        page.server = server
        yield page
    server.stop()


def names(place: Place, suffix: str) -> list[str]:
    """Names that lead out of the folder, or are none."""
    secret = f"secret.{suffix}"
    return [
        f"../outside/{secret}", f"./../outside/{secret}", f"deep/../../outside/{secret}", f"{place.outside}/{secret}",
        f"/{place.outside}/{secret}", f"/proc/self/cwd/{place.outside}/{secret}", f"link.{suffix}", f"way/{secret}",
        f"deep/../way/{secret}", f"null.{suffix}", f"circle.{suffix}", f"pipe.{suffix}", "/etc/passwd", "/dev/stdin",
        "/dev/zero", "/proc/self/environ", f"~/{secret}", f"~root/{secret}", f"$HOME/{secret}",
        f"file://{place.outside}/{secret}", f"%2e%2e/outside/{secret}", f"..%2foutside%2f{secret}",
        f"..\\outside\\{secret}", f"here.yaml\0../outside/{secret}", f"../outside/{secret}\0.{suffix}",
        f"here.yaml/../../outside/{secret}", f"{'x/' * 300}{secret}", f"{'../' * 300}etc/passwd", "x" * 100_000, "..",
        ".", "/", "", " ", "-", "deep", "deep/", f".hidden.{suffix}", ".git/config", "CON", f"\n{secret}",
        f"{secret}\N{RIGHT-TO-LEFT OVERRIDE}", f"../project/../outside/{secret}", f"\N{FULLWIDTH FULL STOP}./{secret}",
    ]  # fmt: skip


def alert(page: BarePage, since: int) -> str:
    """The refusal that a dialog or a card shows; empty where there is none."""
    alerts = [text for text in page.texts[since:] if 'role="alert"' in text]
    return unescape(re.sub("<[^>]*>", "", alerts[-1])) if alerts else ""


def remark(page: BarePage, since: int, timeout_s: float = 30.0) -> str:
    """Wait for a refusal."""
    return page.wait_for(lambda: alert(page, since), "a remark", timeout_s)


def refused_choice(page: BarePage, label: str, name: str) -> str:
    """Choose a name until it is refused: the choice is lost where the page just sets back the one before."""
    page.notes.clear()
    while True:
        page.set(label, name, "Dropdown")
        try:
            return page.next_note(1.0)
        except AssertionError:
            assert len(page.texts) < 5000


def open_board(page: BarePage, name: str) -> str:
    return refused_choice(page, "Workpiece", name)


def open_cell(page: BarePage, name: str) -> str:
    return refused_choice(page, "Cell", name)


def compare(page: BarePage, name: str) -> str:
    return refused_choice(page, "With", name)


def analyse_with(page: BarePage, name: str) -> str:
    page.set("Parameters", name, "Dropdown")
    page.wait_for(lambda: page.server.sessions.pages()[0].session.parameters_name == name, "the choice")
    since = len(page.texts)
    while True:
        page.set("Analyse", True)
        try:
            return remark(page, since, 1.0)
        except AssertionError:  # pressed while the analysis before was about to end, which it cancelled
            assert len(page.texts) < since + 100


def in_dialog(page: BarePage, action: str, label: str, name: str, button: str) -> str:
    page.set("File", action, "ButtonGroup")
    page.wait_for(lambda: button in shown(page), "the dialog")
    since = len(page.texts)
    refused = page.insist(lambda: page.submit(label, name, button), lambda: alert(page, since), "a remark")
    page.set("Cancel", True, "ButtonMessage")
    page.wait_for(lambda: button not in shown(page), "the dialog's end")
    return refused


def shown(page: BarePage) -> list[str]:
    """Labels of the buttons."""
    return [each["props"]["label"] for each in page.inputs.values() if each["type"] == "GuiButtonMessage"]


def open_recipe(page: BarePage, name: str) -> str:
    return in_dialog(page, "Open\N{HORIZONTAL ELLIPSIS}", "Recipe", name, "Open")


def upload(page: BarePage, name: str, label: str) -> str:
    transfer = f"{label}-{next(NUMBERS)}"
    page.upload(label, name, 1, 1, transfer)
    page.part(label, 0, b"x", transfer)
    return page.next_note()


NUMBERS = itertools.count()
INPUTS = {
    "board": (open_board, "tri"),
    "cell": (open_cell, "yaml"),
    "parameters": (analyse_with, "yaml"),
    "compared recipe": (compare, "yaml"),
    "opened recipe": (open_recipe, "yaml"),
    "imported board": (lambda page, name: upload(page, name, "Import CAD"), "tri"),
    "parts table": (lambda page, name: upload(page, name, "Join parts table"), "yaml"),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", INPUTS)
def test_names_that_lead_out_are_refused_wherever_the_page_sends_them(page, place, kind) -> None:
    attempt, suffix = INPUTS[kind]
    before, attacks = place.files(), names(place, suffix)
    assert len(attacks) >= 40
    if kind == "cell":
        attacks.remove("-")  # no cell
    with opened_below(place.outside, Path("/etc"), Path("/dev"), Path("/proc")) as opened:
        for name in attacks:
            refused = attempt(page, name)
            assert "defect" not in refused, name
            assert len(refused) < 1500, name
    assert [path for path in opened if path != "/dev/null"] == []
    assert place.files() == before


@pytest.mark.slow
def test_a_recipe_is_saved_in_the_folder_alone(page, place) -> None:
    before = place.files()
    with opened_below(place.outside, Path("/etc")) as opened:
        for name in names(place, "yaml"):
            if not re.fullmatch(r"[\w-]*(\.yaml)?", name.strip()):  # such a name is a good one, or none
                in_dialog(page, "Save as\N{HORIZONTAL ELLIPSIS}", "File", name, "Save")
    assert opened == []
    assert place.files() == before


@pytest.mark.parametrize(
    "path",
    [
        "/../../../../etc/passwd", "/..%2f..%2f..%2fetc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd",
        "/assets/../../../../../etc/passwd", "/..\\..\\etc\\passwd", "/%5c..%5c..%5cetc%5cpasswd", "/.//../etc/passwd",
        "/index.html/../../../_viser.py", "/%00", "/etc/passwd%00.html", "/proc/self/environ", "/~root/.profile",
        "/file:///etc/passwd", "/" + "../" * 200 + "etc/passwd", "/here.yaml", "/project/here.yaml",
    ],
)  # fmt: skip
def test_addresses_lead_to_the_page_alone(page, path) -> None:
    with opened_below(Path("/etc"), Path("/proc")) as opened:
        fields = f"Host: 127.0.0.1:{page.server.port}", cookie_of(page.server)
        status, _, body = answer(page.server.port, *fields, path=path)
    assert opened == []
    assert status in (0, 404, 500)
    assert b"root:" not in body


EXTENDS = (
    "../outside/secret.yaml", "./../outside/secret.yaml", "deep/../../outside/secret.yaml", "{outside}/secret.yaml",
    "//{outside}/secret.yaml", "link.yaml", "way/secret.yaml", "null.yaml", "pipe.yaml", "circle.yaml", "/etc/passwd",
    "/dev/zero", "~/secret.yaml", "file://{outside}/secret.yaml", "%2e%2e/outside/secret.yaml", "a\0b.yaml",
)  # fmt: skip


def apply_text(page: BarePage, text: str) -> str:
    page.set("YAML", text)
    since = len(page.texts)
    page.set("Text", "Apply text", "ButtonGroup")
    return remark(page, since)


@pytest.mark.slow
def test_a_text_extends_nothing_outside(page, place) -> None:
    start = open_text(page, place, "typed.yaml", RECIPE.replace("recipe: rinse-only", "recipe: typed"))
    assert start == ""
    with opened_below(place.outside, Path("/etc"), Path("/dev")) as opened:
        for number, name in enumerate(EXTENDS):
            stated = name.format(outside=place.outside)
            refused = apply_text(
                page, "#\n" * number + f"recipe: typed\ndescription: x\nextends: {json.dumps(stated)}\n"
            )
            assert refused.startswith(f"Line {number + 3}: extends: "), refused
            if "outside" in name or "link" in name or "way" in name:
                assert "outside the project folder" in refused or "no such file" in refused
    assert opened == []


def open_text(page: BarePage, place: Place, name: str, text: str) -> str:
    """Open a recipe that lies in the folder; its refusal, if it is refused."""
    (place.folder / name).write_text(text)
    page.set("File", "Open\N{HORIZONTAL ELLIPSIS}", "ButtonGroup")
    page.wait_for(lambda: "Open" in shown(page), "the dialog")
    since = len(page.texts)

    def alerts() -> list[str]:
        return [text for text in page.texts[since:] if 'role="alert"' in text and "elsewhere" not in text]

    submit = partial(page.submit, "Recipe", name, "Open")
    page.insist(submit, lambda: alerts() or "Open" not in shown(page), "an answer")
    if not alerts():
        return ""
    page.set("Cancel", True, "ButtonMessage")
    page.wait_for(lambda: "Open" not in shown(page), "the dialog's end")
    return unescape(re.sub("<[^>]*>", "", alerts()[-1]))


@pytest.mark.slow
def test_a_recipe_of_the_folder_extends_nothing_outside(page, place) -> None:
    with opened_below(place.outside, Path("/etc"), Path("/dev")) as opened:
        for number, name in enumerate(EXTENDS):
            stated = name.format(outside=place.outside)
            (place.folder / f"bad{number}.yaml").write_text(f"recipe: bad\nextends: {json.dumps(stated)}\n")
            (place.folder / f"chain{number}.yaml").write_text(f"recipe: chain\nextends: bad{number}.yaml\n")
            for file in (f"bad{number}.yaml", f"chain{number}.yaml"):
                assert f"bad{number}.yaml:2: extends: " in compare(page, file)
            (place.folder / f"set{number}.yaml").write_text(f"parameters: bad\nextends: {json.dumps(stated)}\n")
            assert f"set{number}.yaml:2: extends: " in analyse_with(page, f"set{number}.yaml")
    assert opened == []


MESH = "  part: {kind: mesh, file: NAME}\n"
CELLS = {
    "robot": (
        "robot: ur5e", "robot: NAME",
        ("../outside/cell.yaml", "{outside}/cell.yaml", "way/cell.yaml", "../outside/robot", "{outside}/robot",
         "link.yaml", "/etc/passwd", "pipe.yaml", "null.yaml"),
    ),
    "urdf": (
        "robot: ur5e", "robot: {urdf: NAME}",
        ("../outside/robot.urdf", "{outside}/robot.urdf", "way/robot.urdf", "/etc/passwd", "/dev/zero", "~/robot.urdf"),
    ),
    "mesh": (
        "fixtures:\n", f"fixtures:\n{MESH}",
        ("../outside/m.obj", "{outside}/m.obj", "way/m.obj", "/etc/passwd", "../m.obj", "file:///m.obj"),
    ),
    "tool": ("    bodies:\n", f"    bodies:\n    {MESH}", ("../outside/m.obj", "{outside}/m.obj", "way/m.obj")),
}  # fmt: skip


REASONS = ("outside the project folder", "no such", "not a file", "a mesh is read from")


@pytest.mark.slow
@pytest.mark.parametrize("kind", CELLS)
def test_a_cell_names_nothing_outside(page, place, kind) -> None:
    old, new, stated = CELLS[kind]
    with opened_below(place.outside, Path("/etc"), Path("/dev")) as opened:
        for number, name in enumerate(stated):
            file = f"{kind}{number}.yaml"
            (place.folder / file).write_text(
                CELL.replace(old, new.replace("NAME", name.format(outside=place.outside)), 1)
            )
            refused = open_cell(page, file)
            assert re.search(rf"{file}:\d+: ", refused), refused
            assert (
                "outside the project folder" in refused
                or "no such" in refused
                or "not a file" in refused
                or "a mesh is read from" in refused
            )
    assert [path for path in opened if path != "/dev/null"] == []


@pytest.mark.parametrize(
    "mesh",
    [
        "../outside/m.obj", "{outside}/m.obj", "way/m.obj", "package://two/../outside/m.obj", "package://two/outside/m.obj",
        "package://two/m.obj", "file://{outside}/m.obj", "/etc/passwd",
    ],
)  # fmt: skip
def test_a_urdf_names_nothing_outside(page, place, mesh) -> None:
    (place.folder / "own.urdf").write_text(URDF.format(mesh=mesh.format(outside=place.outside)))
    (place.folder / "urdf.yaml").write_text(CELL.replace("robot: ur5e", "robot: {urdf: own.urdf}"))
    with opened_below(place.outside, place.folder.parent / "m.obj", Path("/etc")) as opened:
        refused = open_cell(page, "urdf.yaml")
    assert opened == []
    assert "urdf.yaml:2: robot.urdf: " in refused
    assert "own.urdf:1: <mesh> names " in refused
    assert "outside" in refused or "give a path" in refused


@pytest.mark.parametrize(
    "uri",
    [
        "../outside/secret.bin", "{outside}/secret.bin", "way/secret.bin", "%2e%2e/outside/secret.bin",
        "..%2Foutside%2Fsecret.bin", "file://{outside}/secret.bin", "link.bin", "./deep/../../outside/secret.bin",
        "/etc/passwd", "/dev/zero", "pipe.tri", "", "%00", "~/secret.bin", "https://evil.example/secret.bin",
        "data:,abc",
    ],
)  # fmt: skip
def test_a_gltf_names_nothing_outside(page, place, uri) -> None:
    if not (place.folder / "link.bin").is_symlink():
        (place.folder / "link.bin").symlink_to(place.outside / "secret.bin")
    buffer = {"uri": uri.format(outside=place.outside), "byteLength": 36}
    text = json.dumps({"asset": {"version": "2.0"}, "buffers": [buffer], "meshes": []}, indent=1)
    (place.folder / "board.gltf").write_text(text)
    with opened_below(place.outside, Path("/etc"), Path("/dev")) as opened:
        refused = open_board(page, "board.gltf")
    assert opened == []
    assert "board.gltf:7: its data file" in refused or not uri


def test_an_obj_and_a_ply_name_nothing(page, place) -> None:
    (place.folder / "a.obj").write_text(f"mtllib ../outside/m.obj\nusemtl x\n{TRIANGLE}")
    (place.folder / "b.obj").write_text(f"mtllib {place.outside}/secret.bin\n{TRIANGLE}")
    ply = "ply\nformat ascii 1.0\ncomment TextureFile ../outside/secret.bin\nelement vertex 3\nproperty float x\n"
    ply += "property float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    (place.folder / "c.ply").write_text(f"{ply}0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    with opened_below(place.outside) as opened:
        for name in ("a.obj", "b.obj", "c.ply"):
            open_board(page, name)
    assert opened == []


def test_an_idf_has_its_library_in_the_folder(page, place) -> None:
    (place.folder / "library.emn").write_text(IDF_HEAD.format(kind="BOARD_FILE", rest="board MM\n"))
    (place.folder / "library.emp").symlink_to(place.outside / "library.emp")
    with opened_below(place.outside) as opened:
        open_board(page, "library.emn")
        open_board(page, "library.emp")
    assert opened == []


@pytest.mark.slow
def test_files_of_the_folder_and_of_the_libraries_are_read(page, place) -> None:
    (place.folder / "deep" / "base.yaml").write_text(RECIPE.replace("recipe: rinse-only", "recipe: base"))
    assert open_text(page, place, "good.yaml", "recipe: good\nextends: deep/base.yaml\n") == ""
    assert open_text(page, place, "deep/good.yaml", "recipe: good\nextends: ../deep/base.yaml\n") == ""
    data = base64.b64decode("AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA")
    (place.folder / "deep" / "a b.bin").write_bytes(data)
    buffer = {"uri": "deep/a%20b.bin", "byteLength": 36}
    (place.folder / "good.gltf").write_text(json.dumps({"asset": {"version": "2.0"}, "buffers": [buffer]}))
    assert "holds no triangles" in open_board(page, "good.gltf")
    page.set("Cell", "ur5e-bench", "Dropdown")
    page.wait_for(lambda: any("ur5e" in text for text in page.texts), "the cell")
    assert page.notes == []


def test_a_parts_table_is_read_although_it_is_not_kept(page, place) -> None:
    before = place.files()
    page.notes.clear()
    page.upload("Join parts table", "parts.csv", 1, 1, "table")
    page.part("Join parts table", 0, b"x", "table")
    assert "parts.csv: no line names the columns" in page.next_note()
    assert place.files() == before
