"""Every reader as the commands call it, with the small valid files that its cases are made of."""

import gzip
import os
import signal
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "tests" / "support"), str(ROOT)]

import trimesh
from ecad_writers import EcadBoard, EcadPart, gerber_copper, gerber_profile, ipc2581, odb, write_tgz, write_zip
from shapely import box
from small_programs import hand_program
from step_writer import StepWriter

import boards.formats.step
from boards.board import Body
from boards.formats.prism import prism
from boards.formats.step_child import bound_resources, convert
from boards.formats.tri.tri import write_tri
from boards.load import load_board
from cleaning.calibration.coupon import CouponSetup
from cleaning.calibration.fit_kinetics import calibrate_gap
from cleaning.calibration.fit_spray import calibrate_ring
from cleaning.calibration.fitted_files import choose_nozzle
from cleaning.parameters.load import load_parameters
from programs import native
from programs.load import load_program
from recipes.load import load_recipe
from robotcell.cell.load import read_cell
from specs.progress import Progress
from studies.study import load_study

_DATA = ROOT / "tests" / "boards" / "data"
_MIB = 1 << 20


@dataclass(frozen=True, slots=True)
class Reader:
    """One kind of input."""

    seeds: tuple[bytes, ...]
    file: str
    """Name of the mutated file."""
    read: Callable[[Path], object]
    beside: tuple[tuple[str, bytes], ...] = ()
    """Files that lie beside it, unchanged."""


def make_readers() -> dict[str, Reader]:
    """Make the readers by name, and whatever they read beside the case."""
    tri = _small_tri()
    meshes = {kind: _meshes(kind) for kind in ("stl", "obj", "ply", "glb", "gltf")}
    notched = {suffix: (_DATA / f"notched.{suffix}").read_bytes() for suffix in ("emn", "emp")}
    step = StepWriter().write([
        ("R1", "R_0603", (1.6, 0.8, 0.5), (-8, 5, 1.6)), ("bare", "card PCB", (40, 30, 1.6), (2, 1, 0))
    ]).encode()  # fmt: skip
    kicad = tuple((_DATA / f"small_v{version}.kicad_pcb").read_bytes() for version in (5, 9))
    library = {name: (ROOT / name).read_bytes() for name in _YAML}
    return {
        "kicad": Reader(kicad, "b.kicad_pcb", load_board),
        "eagle": Reader(((_DATA / "small.brd").read_bytes(),), "b.brd", load_board),
        "idf": Reader((notched["emn"],), "b.emn", load_board, (("b.emp", notched["emp"]),)),
        "idf-library": Reader(
            (notched["emp"],), "b.emp", lambda path: load_board(path.with_suffix(".emn")), (("b.emn", notched["emn"]),)
        ),
        **_exports(),
        "tri": Reader((tri, _LEGACY), "b.tri", load_board),
        "tri.gz": Reader((gzip.compress(tri, mtime=0),), "b.tri.gz", load_board),
        **{kind: Reader(seeds, f"b.{kind}", load_board) for kind, seeds in meshes.items()},
        "step": Reader((step,), "b.step", load_board),
        "parts": Reader(
            _TABLES, "b.csv", lambda path: load_board(path.with_name("a.tri"), path), (("a.tri", tri),)
        ),
        "recipe": Reader((library["recipes/library/smt-aqueous.yaml"], _RECIPE), "b.yaml", load_recipe),
        "study": Reader((_STUDY,), "b.yaml", load_study),
        "cell": Reader((library["robotcell/library/cells/gantry.yaml"],), "b.yaml", read_cell),
        "urdf": Reader(
            (library["robotcell/library/robots/gantry/gantry.urdf"],),
            "b.urdf",
            lambda path: read_cell(path.with_name("a.yaml")),
            (("a.yaml", _CELL),),
        ),
        "mesh": Reader(
            meshes["stl"], "b.stl", lambda path: read_cell(path.with_name("a.yaml")), (("a.yaml", _MESH_CELL),)
        ),
        "parameters": Reader(
            (library["cleaning/library/default.yaml"], library["cleaning/library/aged.yaml"]), "b.yaml", load_parameters
        ),
        "ring": Reader(_RINGS, "b.csv", lambda path: calibrate_ring(path, "volume")),
        "gap": Reader((_COUPONS,), "b.csv", lambda path: calibrate_gap(path, _setup())),
        "program": Reader((native.render(hand_program()).encode(),), "b.wash", load_program),
    }  # fmt: skip


def _setup() -> CouponSetup:
    known = load_parameters("default")
    washing = next(liquid for liquid in known.liquids.values() if liquid.use == "wash")
    return CouponSetup(choose_nozzle("smt-aqueous", None)[1], washing, known)


def _small_tri() -> bytes:
    def body(name: str, role: str, outline: object, low: float, high: float, **stated: object) -> Body:
        return Body(name, role, *prism(outline, low, high), **stated)  # type: ignore[arg-type]

    hole = box(0, 0, 50, 40).difference(box(5, 5, 9, 9))
    parts = [(f"R{n}", box(12 + 6 * n, 10, 14 + 6 * n, 11), 0.5) for n in range(5)]
    return write_tri([
        body("board", "board", hole, 0.0, 1.6),
        *(body(name, "component", plan, 1.6, 1.6 + high, package="R_0805", side="top") for name, plan, high in parts),
        body("U1", "component", box(20, 20, 30, 30), 1.7, 3.2, package="QFN-32", pins=32, gap_height_mm=0.1),
    ]).encode()  # fmt: skip


def _exports() -> dict[str, Reader]:
    """What ECAD systems export: as text, and packed."""
    parts = (EcadPart("U1", 9.0, 9.0, 4.0, 3.0, 1.0, 30.0, "top", pins=4), EcadPart("C1", 20, 9, 2, 1, 1, 90, "bottom"))
    card = EcadBoard(box(0, 0, 30, 20).difference(box(13, 8, 15, 10)), 1.6, parts, ((3.0, 3.0, 1.5),))
    job = odb(card)
    packed: dict[str, bytes] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, write in (("b.tgz", write_tgz), ("b.zip", write_zip)):
            write(job, Path(folder) / name)
            packed[name] = (Path(folder) / name).read_bytes()
    texts = {
        "odb-profile": "steps/card/profile",
        "odb-components": "steps/card/layers/comp_+_top/components",
        "odb-packages": "steps/card/eda/data",
        "odb-matrix": "matrix/matrix",
    }
    beside = tuple((name, text.encode()) for name, text in job.items())
    return {
        "ipc2581": Reader(
            (ipc2581(card, "B", "INCH").encode(), ipc2581(card, copper=True).encode()), "b.xml", load_board
        ),
        "gerber": Reader((gerber_profile(card).encode(),), "b.gbr", load_board),
        "gerber-copper": Reader(
            (gerber_copper(card, "top").encode(),),
            "g/b.gbr",
            lambda path: load_board(path.parent),
            (("g/a.gbr", gerber_profile(card).encode()),),
        ),
        "odb-tgz": Reader((packed["b.tgz"],), "b.tgz", load_board),
        "odb-zip": Reader((packed["b.zip"],), "b.zip", load_board),
        **{
            kind: Reader(
                (job[name].encode(),),
                f"j/{name}",
                partial(_load_job, depth=name.count("/") + 1),
                tuple((f"j/{each}", text) for each, text in beside if each != name),
            )
            for kind, name in texts.items()
        },
    }


def _load_job(path: Path, depth: int) -> object:
    """Read the job that a file lies in, that many folders below its root."""
    return load_board(path.parents[depth - 1])


def _meshes(kind: str) -> tuple[bytes, ...]:
    scene = trimesh.Scene()
    for name, size, at in (
        ("PCB", (60, 40, 1.6), (0, 0, 0.8)),
        ("R1", (2, 1, 0.5), (5, 5, 1.85)),
        ("U1", (7, 7, 1), (-9, 3, 2.1)),
    ):
        mesh = trimesh.creation.box(size)
        mesh.apply_translation(at)
        scene.add_geometry(mesh, node_name=name, geom_name=f"mesh of {name}")
    whole = trimesh.util.concatenate(list(scene.geometry.values()))
    match kind:
        case "glb":
            return (bytes(scene.export(file_type="glb")),)
        case "gltf":
            import base64
            import json

            files = scene.export(file_type="gltf")
            header = json.loads(files["model.gltf"])
            for buffer in header["buffers"]:
                content = base64.b64encode(files[buffer["uri"]]).decode()
                buffer["uri"] = f"data:application/octet-stream;base64,{content}"
            return (json.dumps(header).encode(),)
        case "stl":
            return bytes(whole.export(file_type="stl")), str(whole.export(file_type="stl_ascii")).encode()
        case "ply":
            return (
                bytes(whole.export(file_type="ply", encoding="ascii")),
                bytes(whole.export(file_type="ply", encoding="binary")),
            )
        case _:
            plain = str(whole.export(file_type="obj", include_normals=False))
            first, _, rest = plain.partition("\nf ")
            return plain.encode(), f"{first}\ng a\nf {rest}".replace("\nf 9 ", "\ng b\nf 9 ", 1).encode()


def convert_in_fork(data: bytes, bounds: boards.formats.step.Bounds, _: Progress) -> tuple[int, bytes, str]:
    """Stand in for the child process of STEP by a fork, which is there at once; with the bounds of the child."""
    out, log = os.memfd_create("glb"), os.memfd_create("log")
    child = os.fork()
    if child == 0:
        try:
            for each in (1, 2):
                os.dup2(log, each)
            bound_resources(bounds.cpu_s, bounds.memory_bytes)
            os.write(out, convert(data))
            os._exit(0)
        except BaseException as error:
            os.write(2, f"{type(error).__name__}: {error}\n".encode())
            os._exit(1)
    try:
        status = os.waitpid(child, 0)[1]
        code = -os.WTERMSIG(status) if os.WIFSIGNALED(status) else os.WEXITSTATUS(status)
        glb, text = (os.pread(each, 100 * _MIB, 0) for each in (out, log))
        return code, glb, boards.formats.step._COLOUR.sub("", text.decode(errors="replace"))
    except BaseException:
        os.kill(child, signal.SIGKILL)
        raise
    finally:
        os.close(out)
        os.close(log)


_YAML = (
    "recipes/library/smt-aqueous.yaml", "robotcell/library/cells/gantry.yaml", "cleaning/library/default.yaml",
    "cleaning/library/aged.yaml", "robotcell/library/robots/gantry/gantry.urdf",
)  # fmt: skip
_TABLES = (
    b"Ref,Val,Package,PosX,PosY,Rot,Side,Pins,Height (mm),Standoff\nR0,10k,R_0805,13,10.5,0,top,2,0.5,0.05\n"
    b'R1,"1,2k",R_0805,19,10.5,90,top,2,0.5,\nU1,MCU,QFN-32,25mm,25mm,180,top,32,1.5,0.1mm\n"R2, R3-R4",1k,,,,,,,,\n',
    b"### Module positions\n## Unit = mm, Angle = deg.\n# Ref     Val       Package  PosX   PosY   Rot  Side\n"
    b"R0  10k  R_0805  13.0  10.5  0.0  top\nX1  10k  R_0805  19.0  10.5  0.0  top\nX2  a  b  25.0  25.0  0.0  top\n",
    b"Designator\tMid X\tMid Y\tLayer\tFootprint\nR0\t512mil\t413mil\tT\tR_0805\nR1\t748mil\t413mil\tT\tR_0805\n",
)
_LEGACY = b"1\n1\n12\n" + b"".join(b"0 0 0 60 0 0 60 40 0 0 0 -1\n0 0 1.6 60 0 1.6 60 40 1.6 0 0 1\n" for _ in range(6))
_RECIPE = b"recipe: s\nextends: smt-aqueous\ntemplates: {around: {height_mm: 40, speed_mm_s: 30}}\n"
_STUDY = b"""study: s
boards: [tiny, {board: b.kicad_pcb, parts: b.csv}]
recipes: [smt-aqueous]
variables:
  - {path: templates.sweep.speed_mm_s, low: 30, high: 60, steps: 3}
  - {path: templates.around.height_mm, values: [auto, 40, 50.5]}
tolerances: {samples: 4, deviations: {standoff_mm: {distribution: normal, sigma: 1}}}
"""
_RINGS = (
    b"height_mm,tilt_deg,azimuth_deg,inner_mm,outer_mm\n"
    + b"".join(b"%d,%d,%d,%d.5,%d\n" % (h, t, a, 0.45 * h + t / 9, 0.7 * h + t / 7) for h, t, a in
               [(h, t, a) for h in (40, 60) for t in (0, 20) for a in (0, 60, 120, 180, 240, 300)]),
    b"height_mm,tilt_deg,azimuth_deg,x_mm,y_mm,intensity\n"
    + b"".join(b"%d,0,0,%d,%d,%d\n" % (h, x, y, max(0, 9 - abs((x * x + y * y) ** 0.5 - 0.57 * h)))
               for h in (40, 60) for x in range(-45, 46, 9) for y in range(-45, 46, 9)),
)  # fmt: skip
_COUPONS = b"standoff_um,time_s,temperature_c,pressure_bar,cleaned_fraction\n" + b"".join(
    b"%d,%d,%d,3.5,%.3f\n" % (gap, time, warm, min(0.97, gap * time * warm / 6e6))
    for gap in (25, 100) for time in (60, 300, 900) for warm in (45, 60)
)  # fmt: skip
_CELL = b"""cell: a
robot: {urdf: b.urdf, joints: {all: {acceleration_deg_s2: 400, acceleration_mm_s2: 4000}}}
home_deg_mm: [0, 0, 0, 0, 0]
board: {pose: {xyz_mm: [400, -50, 150]}}
tools: {1: {name: lance, tcp: {xyz_mm: [0, 0, 170]}}}
nozzles: {}
io: {outputs: {}}
"""
_MESH_CELL = (
    (ROOT / "robotcell/library/cells/gantry.yaml")
    .read_bytes()
    .replace(b"fixtures:\n", b"fixtures:\n  m: {kind: mesh, file: b.stl}\n")
)
