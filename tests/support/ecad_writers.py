"""Writers of IPC-2581, ODB++ and Gerber files, after their standards and apart from the readers.

A part is a box on a package of its own with two pins or more; its place and its turn are as seen from the top. Packages
are drawn as seen from their own side.
"""

import io
import math
import tarfile
import zipfile
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from xml.sax.saxutils import quoteattr

from shapely import Polygon

UNITS = {"MILLIMETER": 1.0, "MICRON": 0.001, "INCH": 25.4, "MM": 1.0}


@dataclass(frozen=True)
class EcadPart:
    """A box on one side."""

    name: str
    x: float
    y: float
    width: float
    depth: float
    height: float
    turn_deg: float
    side: str
    package: str = ""
    pins: int = 2
    value: str = "10k"
    part: str = "PN-1"

    @property
    def footprint(self) -> str:
        """Name of the package."""
        return self.package or f"Box-{self.name}_{self.width:g}x{self.depth:g}mm"

    def pin_places(self) -> list[tuple[float, float]]:
        """Pins as seen from the part's own side, in two columns inside the body; the first is not its mirror image."""
        rows = math.ceil(self.pins / 2)
        step = 0.8 * self.depth / max(rows, 1)
        return [
            ((0.3 if n % 2 else -0.4) * self.width, (n // 2 - (rows - 1) / 2) * step + 0.05 * self.depth)
            for n in range(self.pins)
        ]

    def pin_size(self) -> tuple[float, float]:
        """Length and width of a pad."""
        return 0.2 * self.width, 0.5 * self.depth / max(math.ceil(self.pins / 2), 1)

    def on_board(self, x: float, y: float) -> tuple[float, float]:
        """Point of the package on the board."""
        x = -x if self.side == "bottom" else x
        cos, sin = math.cos(math.radians(self.turn_deg)), math.sin(math.radians(self.turn_deg))
        return self.x + cos * x - sin * y, self.y + sin * x + cos * y


@dataclass(frozen=True)
class EcadBoard:
    """A board with its parts, and how often it is repeated on a panel: place, turn and mirror of each instance."""

    outline: Polygon
    thickness: float
    parts: tuple[EcadPart, ...]
    holes: tuple[tuple[float, float, float], ...] = ()
    """x, y and diameter."""
    scores: tuple[tuple[float, float, float, float], ...] = ()
    """Ends of lines on a layer of their own."""
    scoring: str = "V_CUT"
    """Function of that layer in IPC-2581; type and name in ODB++."""


PANEL_EDGE = [(-20.0, -20.0), (200.0, -20.0), (200.0, 150.0), (-20.0, 150.0), (-20.0, -20.0)]
Repeat = tuple[float, float, int, int, float, float, float, bool]
"""x, y, counts and pitches along x and y, turn anticlockwise from the top after mirroring, and whether mirrored."""


def ipc2581(
    board: EcadBoard,
    revision: str = "C",
    units: str = "MILLIMETER",
    copper: bool = False,
    repeats: Sequence[Repeat] = (),
) -> str:
    """Write an IPC-2581 file: rotations anticlockwise, then mirrored in x.

    Args:
        board: To be written.
        revision: B or C.
        units: MILLIMETER, MICRON or INCH.
        copper: Whether the copper of pins is written, too.
        repeats: Of the board on a panel.
    """

    def n(value: float) -> str:
        return f"{value / UNITS[units]:.7f}"

    def polygon(points: Iterable[tuple[float, float]], tag: str = "Polygon") -> str:
        (x, y), *rest = points
        steps = "".join(f'<PolyStepSegment x="{n(u)}" y="{n(v)}"/>' for u, v in rest)
        return f'<{tag}><PolyBegin x="{n(x)}" y="{n(y)}"/>{steps}</{tag}>'

    packages: dict[str, str] = {}
    components: list[str] = []
    pads: list[str] = []
    for part in board.parts:
        w, d = part.width / 2, part.depth / 2
        length, width = part.pin_size()
        pins = "".join(
            f'<Pin number="{number}" type="SURFACE" electricalType="ELECTRICAL"><Location x="{n(x)}" y="{n(y)}"/>'
            f'<RectCenter width="{n(length)}" height="{n(width)}"/></Pin>'
            for number, (x, y) in enumerate(part.pin_places(), start=1)
        )
        packages[part.footprint] = (
            f'<Package name={quoteattr(part.footprint)} type="OTHER" height="{n(part.height)}"><Outline>'
            f'{polygon([(-w, -d), (w, -d), (w, d), (-w, d), (-w, -d)])}<LineDesc lineWidth="0.1" lineEnd="ROUND"/>'
            f'</Outline><PickupPoint x="0" y="0"/>{pins}</Package>'
        )
        bottom = part.side == "bottom"
        turn = (-part.turn_deg if bottom else part.turn_deg) % 360.0
        mirror = ' mirror="true"' if bottom else ""
        components.append(
            f'<Component refDes="{part.name}" packageRef={quoteattr(part.footprint)} part="{part.part}" '
            f'layerRef="{"BOTTOM" if bottom else "TOP"}" mountType="SMT"><Xform rotation="{turn:.6f}"{mirror}/>'
            f'<Location x="{n(part.x)}" y="{n(part.y)}"/></Component>'
        )
        for number, place in enumerate(part.pin_places() if copper else (), start=1):
            x, y = part.on_board(*place)
            pads.append(
                f'<Set><Pad padstackDefRef="P"><Location x="{n(x)}" y="{n(y)}"/>'
                f'<PinRef componentRef="{part.name}" pin="{number}"/></Pad></Set>'
            )
    holes = "".join(
        f'<Set><Hole name="H" diameter="{n(size)}" platingStatus="NONPLATED" plusTol="0" minusTol="0" '
        f'x="{n(x)}" y="{n(y)}"/></Set>'
        for x, y, size in board.holes
    )
    bom = "".join(
        f'<BomItem OEMDesignNumberRef="{part.part}" quantity="1" category="ELECTRICAL">'
        f'<RefDes name="{part.name}" packageRef={quoteattr(part.footprint)} populate="true" layerRef="TOP"/>'
        f'<Characteristics category="ELECTRICAL"><Textual definitionSource="x" textualCharacteristicName="Value" '
        f'textualCharacteristicValue="{part.value}"/><Textual textualCharacteristicName="MPN" '
        f'textualCharacteristicValue="{part.part}"/></Characteristics></BomItem>'
        for part in board.parts
    )
    steps = "".join(
        f'<StepRepeat stepRef="card" x="{n(x)}" y="{n(y)}" nx="{nx}" ny="{ny}" dx="{n(dx)}" dy="{n(dy)}" '
        f'angle="{(-turn if over else turn) % 360.0:.6f}" mirror="{str(over).lower()}"/>'
        for x, y, nx, ny, dx, dy, turn, over in repeats
    )
    panel = f'<Step name="array"><Datum x="0" y="0"/>{steps}</Step>' if repeats else ""
    if panel:  # a panel has a profile
        panel = panel.replace(steps, f"<Profile>{polygon(PANEL_EDGE)}</Profile>{steps}")
    lines = "".join(
        f'<Set><Features><Location x="{n(1.0)}" y="{n(-2.0)}"/><UserSpecial><Line startX="{n(x - 1.0)}" '
        f'startY="{n(y + 2.0)}" endX="{n(u - 1.0)}" endY="{n(v + 2.0)}"><LineDesc lineWidth="0.1" lineEnd="ROUND"/>'
        "</Line></UserSpecial></Features></Set>"
        for x, y, u, v in board.scores
    )
    cutouts = "".join(polygon(ring.coords, "Cutout") for ring in board.outline.interiors)
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<IPC-2581 revision="{revision}" xmlns="http://webstds.ipc.org/2581">'
        '<Content roleRef="Owner"><FunctionMode mode="ASSEMBLY"/><StepRef name="card"/></Content>'
        f'<Bom name="b"><BomHeader assembly="a" revision="1"/>{bom}</Bom><Ecad name="e"><CadHeader units="{units}"/>'
        '<CadData><Layer name="TOP" layerFunction="CONDUCTOR" side="TOP" polarity="POSITIVE"/>'
        '<Layer name="BOTTOM" layerFunction="CONDUCTOR" side="BOTTOM" polarity="POSITIVE"/>'
        f'<Layer name="V" layerFunction="{board.scoring}" side="NONE" polarity="POSITIVE"/>'
        f'<Stackup name="s" overallThickness="{n(board.thickness)}" tolPlus="0" tolMinus="0" whereMeasured="MASK"/>'
        f'<Step name="card"><Datum x="0" y="0"/><Profile>{polygon(board.outline.exterior.coords)}{cutouts}</Profile>'
        f"{''.join(packages.values())}\n{chr(10).join(components)}\n"
        f'<LayerFeature layerRef="TOP">{"".join(pads)}</LayerFeature><LayerFeature layerRef="D">{holes}</LayerFeature>'
        f'<LayerFeature layerRef="V">{lines}</LayerFeature>'
        f"</Step>{panel}</CadData></Ecad></IPC-2581>\n"
    )


def _scores(board: EcadBoard, number: Callable[[float], str], pen: str) -> tuple[list[tuple[str, str]], list[str]]:
    """Rows of the matrix for the layer of scores, whose type and name the board states, and its features."""
    kind, _, name = board.scoring.partition(" ")
    ways = (" ".join(map(number, line)) for line in board.scores)
    return [(name, kind)] if board.scores else [], [f"$0 r{pen}", *(f"L {way} 0 P 0" for way in ways)]


def odb(board: EcadBoard, unit: str = "MM", repeats: Sequence[Repeat] = ()) -> dict[str, str]:
    """Write the files of an ODB++ job by their paths: rotations clockwise, after x was mirrored on the bottom."""

    def n(value: float) -> str:
        return f"{value / UNITS[unit]:.7f}"

    def contour(points: Sequence[tuple[float, float]], kind: str = "I") -> list[str]:
        (x, y), *rest = points
        return [f"OB {n(x)} {n(y)} {kind}", *(f"OS {n(u)} {n(v)}" for u, v in rest), "OE"]

    head = [f"UNITS={unit}", "#"]
    rings = [(board.outline.exterior, "I"), *((ring, "H") for ring in board.outline.interiors)]
    profile = [
        *head,
        "F 1",
        "S P 0",
        *(line for ring, kind in rings for line in contour(list(ring.coords), kind)),
        "SE",
    ]
    data = [*head, "HDR test", "NET $NONE$"]
    layers: dict[str, list[str]] = {
        side: [*head, "@0 .comp_mount_type", "@1 .comp_height"] for side in ("top", "bottom")
    }
    numbers: dict[str, int] = {}
    for part in board.parts:
        w, d = part.width / 2, part.depth / 2
        length, width = part.pin_size()
        if part.footprint not in numbers:
            numbers[part.footprint] = len(numbers)
            data += [
                f"PKG {part.footprint} {n(1.0)} {n(-w)} {n(-d)} {n(w)} {n(d)};",
                f"RC {n(-w)} {n(-d)} {n(2 * w)} {n(2 * d)}",
            ]
            for number, (x, y) in enumerate(part.pin_places(), start=1):
                data += [
                    f"PIN {number} S {n(x)} {n(y)} 0 E S",
                    f"RC {n(x - length / 2)} {n(y - width / 2)} {n(length)} {n(width)}",
                ]
        turn, mirror = -part.turn_deg % 360.0, "M" if part.side == "bottom" else "N"
        lines = layers[part.side]
        lines.append(
            f"CMP {numbers[part.footprint]} {n(part.x)} {n(part.y)} {turn:.6f} {mirror} {part.name} {part.part} "
            f";0=1,1={n(part.height)}"
        )
        lines += [f"PRP VALUE '{part.value}'", f"PRP MPN '{part.part}'"]
        for number, place in enumerate(part.pin_places()):
            x, y = part.on_board(*place)
            lines.append(f"TOP {number} {n(x)} {n(y)} {turn:.6f} {mirror} 0 {number} {number + 1}")
    symbols = sorted({size for *_, size in board.holes})
    per_mm = 1000.0 if unit == "MM" else 1000.0 / 25.4
    drills = [*head, *(f"${place} r{size * per_mm:.4f}" for place, size in enumerate(symbols))]
    drills += [f"P {n(x)} {n(y)} {symbols.index(size)} P 0 0" for x, y, size in board.holes]
    matrix = ["STEP {", "    COL=1", "    NAME=CARD", "}"]
    scored, score_features = _scores(board, n, f"{0.1 * per_mm:.4f}")
    rows = [("COMP_+_TOP", "COMPONENT"), ("COMP_+_BOT", "COMPONENT"), ("D", "DRILL"), *scored]
    for row, (name, kind) in enumerate(rows, 1):
        matrix += ["LAYER {", f"    ROW={row}", "    CONTEXT=BOARD", f"    TYPE={kind}", f"    NAME={name}", "}"]
    step = "steps/card"
    files = {
        "matrix/matrix": matrix,
        "misc/info": [f"UNITS={unit}", "ODB_VERSION_MAJOR=8", "ODB_VERSION_MINOR=1"],
        f"{step}/stephdr": [f"UNITS={unit}", "X_DATUM=0", "Y_DATUM=0"],
        f"{step}/attrlist": [f"UNITS={unit}", f".board_thickness={n(board.thickness)}"],
        f"{step}/profile": profile,
        f"{step}/eda/data": data,
        f"{step}/layers/comp_+_top/components": layers["top"],
        f"{step}/layers/comp_+_bot/components": layers["bottom"],
        f"{step}/layers/d/features": drills,
    }
    files |= {f"{step}/layers/{name}/features": [*head, *score_features] for name, _ in scored}
    if repeats:
        files["matrix/matrix"] = [*matrix, "STEP {", "    COL=2", "    NAME=ARRAY", "}"]
        header = [f"UNITS={unit}"]
        for x, y, nx, ny, dx, dy, turn, over in repeats:
            numbers_of = {"X": n(x), "Y": n(y), "DX": n(dx), "DY": n(dy), "NX": nx, "NY": ny}
            turned = {"ANGLE": f"{-turn % 360.0:.6f}", "MIRROR": "YES" if over else "NO"}
            values = {"NAME": "CARD", **numbers_of, **turned}
            header += ["STEP-REPEAT {", *(f"    {key}={value}" for key, value in values.items()), "}"]
        files["steps/array/stephdr"] = header
        files["steps/array/profile"] = [*head, "F 1", "S P 0", *contour(PANEL_EDGE), "SE"]
    return {name: "\n".join(lines) + "\n" for name, lines in files.items()}


def gencad(board: EcadBoard, unit: str = "INCH", dialect: str = "mirrorx") -> str:
    """A GenCAD file; programs differ in how they mirror what is on the bottom, and in the sense of its turns.

    Args:
        board: To write.
        unit: ``INCH``, ``MM``, or ``USER n`` with n to an inch.
        dialect: ``mirrorx`` and ``mirrory`` mirror about that axis before the turn; ``clockwise`` counts turns so, and
            only the ends of tracks show it.
    """
    scale = {"INCH": 25.4, "MM": 1.0}.get(unit) or 25.4 / float(unit.split()[1])

    def n(*values: float) -> str:
        return " ".join(f"{value / scale:.6f}" for value in values)

    def lines(outline: Polygon) -> list[str]:
        rings = (outline.exterior, *outline.interiors)
        return [f"LINE {n(*a, *b)}" for ring in rings for a, b in pairwise(ring.coords)]

    pads, stacks, shapes, placed, devices, signals, routes = (list[str]() for _ in range(7))
    for part in board.parts:
        length, width = part.pin_size()
        name = part.footprint
        pads += [f'PAD "P {part.name}" RECTANGULAR -1', f"RECTANGLE {n(-length / 2, -width / 2, length, width)}"]
        stacks += [f'PADSTACK "S {part.name}" 0', f'PAD "P {part.name}" TOP 0 0']
        shapes += [f'SHAPE "{name}"', "INSERT SMD", f"HEIGHT {n(part.height)}"]
        shapes.append(f"RECTANGLE {n(-part.width / 2, -part.depth / 2, part.width, part.depth)}")
        is_over = part.side == "bottom"
        half = 180.0 if is_over and dialect == "mirrorx" else 0.0
        turn = -part.turn_deg if dialect == "clockwise" else part.turn_deg + half
        flags = f"{'MIRRORX' if dialect == 'mirrorx' else 'MIRRORY'} FLIP" if is_over else "0 0"
        placed += [
            f"COMPONENT {part.name}",
            f'DEVICE "D {part.name}"',
            f"PLACE {n(part.x, part.y)}",
            f"LAYER {part.side.upper()}",
            f"ROTATION {turn % 360.0}",
            f'SHAPE "{name}" {flags}',
        ]
        devices += [f'DEVICE "D {part.name}"', f'PART "{part.part}"', f'VALUE "{part.value}"']
        for pin, (x, y) in enumerate(part.pin_places(), start=1):
            shapes.append(f'PIN "{pin}" "S {part.name}" {n(x, y)} TOP 0 0')
            signals += [f"SIGNAL N{part.name}{pin}", f"NODE {part.name} {pin}"]
            end = part.on_board(x, y)
            routes += [f"ROUTE N{part.name}{pin}", "TRACK T1", f"LINE {n(*end, end[0] + 2.0, end[1])}"]
    sections = {
        "HEADER": ["GENCAD 1.4", 'USER "test"', f"UNITS {unit}", "ORIGIN 0 0"],
        "BOARD": [f"THICKNESS {n(board.thickness)}", *lines(board.outline)],
        "PADS": pads,
        "PADSTACKS": stacks,
        "SHAPES": shapes,
        "COMPONENTS": placed,
        "DEVICES": devices,
        "SIGNALS": signals,
        "ROUTES": routes,
    }
    return "".join(f"${name}\n" + "\n".join(rows) + f"\n$END{name}\n" for name, rows in sections.items())


def allegro(board: EcadBoard, unit: str = "MILS", *, underscores: bool = True) -> str:
    """Views of an Allegro extract in one text; versions differ in the underscores of titles."""
    scale = {"MILS": 0.0254, "MILLIMETERS": 1.0}[unit]
    thick = f"{board.thickness / scale:.6f} {'mil' if unit == 'MILS' else 'mm'}"
    count = 0

    def n(*values: float) -> list[str]:
        return [f"{value / scale:.4f}" for value in values]

    def view(titles: str, rows: Iterable[Sequence[str]]) -> str:
        head = titles.split()
        shown = head if underscores else [title.replace("_", "") for title in head]
        facts = (
            f"J!card.brd!Fri Nov 27 10:00:00 2026!-1000!-1000!9000!9000!0.001!{unit.lower()}!CARD!{thick}!4!UP TO DATE!"
        )
        return "\n".join(["A!" + "!".join(shown) + "!", facts, *("S!" + "!".join(row) + "!" for row in rows)]) + "\n"

    def ring(points: Sequence[Sequence[float]]) -> list[list[str]]:
        nonlocal count
        count += 1
        sides = pairwise(points)
        return [["LINE", str(count), f"{count} {k}", *n(*a[:2], *b[:2]), "0", "", "", "", ""]
                for k, (a, b) in enumerate(sides)]  # fmt: skip

    parts, pins, pads, drawn = (list[list[str]]() for _ in range(4))
    for part in board.parts:
        length, width = part.pin_size()
        mirror = "YES" if part.side == "bottom" else "NO"
        turn = f"{part.turn_deg % 360.0:.3f}"
        parts.append([part.name, "IC", part.part, *n(part.height), "DEV", "1", "PACKAGE", part.footprint, mirror, turn,
                      *n(part.x, part.y), part.value, "", ""])  # fmt: skip
        for layer in ("TOP", "~DRILL"):
            shape = ["RECTANGLE", *n(length, width)] if layer == "TOP" else ["", "", ""]
            pads.append([f"P_{part.name}", "1", layer, "", "", *shape, *n(0.0, 0.0), "", ""])
        for pin, (x, y) in enumerate(part.pin_places(), start=1):
            pins.append([part.footprint, mirror, str(pin), str(pin), *n(*part.on_board(x, y)), f"P_{part.name}",
                         part.name, turn, ""])  # fmt: skip
        w, d = part.width / 2, part.depth / 2
        corners = [part.on_board(x, y) for x, y in ((-w, -d), (w, -d), (w, d), (-w, d), (-w, -d))]
        layer = "PLACE_BOUND_BOTTOM" if part.side == "bottom" else "PLACE_BOUND_TOP"
        drawn += [[*row, layer, part.footprint, part.name] for row in ring(corners)]
    edge = [["BOARD GEOMETRY", "OUTLINE", *row, ""] for each in (board.outline.exterior, *board.outline.interiors)
            for row in ring(list(each.coords))]  # fmt: skip
    data = " ".join(f"GRAPHIC_DATA_{k}" for k in range(1, 10))
    return "".join([
        view("REFDES COMP_CLASS COMP_PART_NUMBER COMP_HEIGHT COMP_DEVICE_LABEL COMP_INSERTION_CODE SYM_TYPE SYM_NAME "
             "SYM_MIRROR SYM_ROTATE SYM_X SYM_Y COMP_VALUE COMP_TOL COMP_VOLTAGE", parts),
        view("PAD_NAME REC_NUMBER LAYER FIXFLAG VIAFLAG PADSHAPE1 PADWIDTH PADHGHT PADXOFF PADYOFF PADFLASH "
             "PADSHAPENAME", pads),
        view("SYM_NAME SYM_MIRROR PIN_NAME PIN_NUMBER PIN_X PIN_Y PAD_STACK_NAME REFDES PIN_ROTATION TEST_POINT", pins),
        view(f"GRAPHIC_DATA_NAME GRAPHIC_DATA_NUMBER RECORD_TAG {data} SUBCLASS SYM_NAME REFDES", drawn),
        view(f"CLASS SUBCLASS GRAPHIC_DATA_NAME GRAPHIC_DATA_NUMBER RECORD_TAG {data} NET_NAME", edge),
    ])  # fmt: skip


def write_folder(files: dict[str, str], folder: Path) -> None:
    """Write files below a folder."""
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, "utf-8")


def write_tgz(files: dict[str, str], file: Path, root: str = "job/") -> None:
    """Write files into a packed archive."""
    with tarfile.open(file, "w:gz") as archive:
        for name, text in files.items():
            data = text.encode()
            member = tarfile.TarInfo(root + name)
            member.size = len(data)
            archive.addfile(member, io.BytesIO(data))


def write_zip(files: dict[str, str], file: Path) -> None:
    """Write files into a packed archive."""
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            archive.writestr(name, text)


def gerber_profile(board: EcadBoard, unit: str = "MM") -> str:
    """Write the profile layer with X2 attributes, its arcs none."""
    lines = [*gerber_head(unit, "Profile,NP"), "%ADD10C,0.1*%", "D10*"]
    for ring in (board.outline.exterior, *board.outline.interiors):
        (x, y), *rest = ring.coords
        lines += [f"{gerber_xy(x, y, unit)}D02*", *(f"{gerber_xy(u, v, unit)}D01*" for u, v in rest)]
    return "\n".join([*lines, "M02*"]) + "\n"


def gerber_copper(board: EcadBoard, side: str, unit: str = "MM") -> str:
    """Write an outer copper layer whose flashes name their pins; turned rectangles are macros."""
    lines = [*gerber_head(unit, "Copper,L1,Top" if side == "top" else "Copper,L2,Bot")]
    lines += ["%AMTurned*0 length, width and turn*21,1,$1,$2,0,0,$3*%", "%TA.AperFunction,SMDPad,CuDef*%"]
    own = [part for part in board.parts if part.side == side]
    for code, part in enumerate(own, start=10):
        length, width = (size / UNITS[unit] for size in part.pin_size())
        lines.append(f"%ADD{code}Turned,{length:.7f}X{width:.7f}X{part.turn_deg}*%")
    for code, part in enumerate(own, start=10):
        lines.append(f"D{code}*")
        for number, place in enumerate(part.pin_places(), start=1):
            lines += [f"%TO.P,{part.name},{number}*%", f"{gerber_xy(*part.on_board(*place), unit)}D03*"]
    return "\n".join([*lines, "M02*"]) + "\n"


def gerber_head(unit: str, function: str) -> list[str]:
    return [
        f"%TF.FileFunction,{function}*%",
        "%FSLAX46Y46*%",
        f"%MO{'MM' if unit == 'MM' else 'IN'}*%",
        "%LPD*%",
        "G01*",
    ]


def gerber_xy(x: float, y: float, unit: str) -> str:
    return f"X{round(x / UNITS[unit] * 1e6)}Y{round(y / UNITS[unit] * 1e6)}"


def placement_table(board: EcadBoard) -> str:
    """Write the table of placements, turns as seen from the top."""
    rows = ["Ref,Val,Package,PosX,PosY,Rot,Side,Pins,Height,MPN"]
    rows += [
        f"{p.name},{p.value},{p.footprint},{p.x:.6f},{p.y:.6f},{p.turn_deg:.6f},{p.side},{p.pins},{p.height},{p.part}"
        for p in board.parts
    ]
    return "\n".join(rows) + "\n"
