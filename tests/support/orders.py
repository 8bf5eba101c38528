"""Gerber files of a small board with five parts, and tables of it as tools write them."""

from collections.abc import Mapping
from pathlib import Path

from boards.board import Board

HEAD = "%FSLAX46Y46*%\n%MOMM*%\n%ADD10C,0.1*%\n%ADD11R,0.9X0.95*%\n%ADD12R,1.5X0.6*%\n"
SOIC = [(x, y) for x in (-2.7, 2.7) for y in (-1.905, -0.635, 0.635, 1.905)]
PLACES = {"R1": (10, 20), "R3": (18, 25), "R4": (33, 24), "U1": (25, 15), "R2": (12, 8)}
PACKAGES = {"U1": "SOIC-8"}


def pads_of(name: str) -> list[tuple[float, float]]:
    x, y = PLACES[name]
    return [(x + dx, y + dy) for dx, dy in (SOIC if name == "U1" else [(-0.8, 0), (0.8, 0)])]


def flashes(names: str, *, named: bool) -> str:
    lines = [HEAD]
    for name in names.split():
        lines.append("D12*" if name == "U1" else "D11*")
        for pin, (x, y) in enumerate(pads_of(name), start=1):
            lines += [f"%TO.P,{name},{pin}*%"] * named + [f"X{round(x * 1e6)}Y{round(y * 1e6)}D03*"]
    return "\n".join([*lines, "M02*\n"])


def gerbers(folder: Path, *, named: bool = False) -> Path:
    ring = "".join(f"X{x}000000Y{y}000000D{code}*\n" for x, y, code in
                   ((0, 0, "02"), (40, 0, "01"), (40, 30, "01"), (0, 30, "01"), (0, 0, "01")))  # fmt: skip
    files = {
        "b.gko": f"%TF.FileFunction,Profile,NP*%\n{HEAD}D10*\nG01*\n{ring}M02*\n",
        "b.gtl": "%TF.FileFunction,Copper,L1,Top*%\n" * named + flashes("R1 R3 R4 U1", named=named),
        "b.gbl": "%TF.FileFunction,Copper,L2,Bot*%\n" * named + flashes("R2", named=named),
    }
    (folder / "layers").mkdir()
    for name, text in files.items():
        (folder / "layers" / name).write_text(text)
    return folder / "layers"


def table(folder: Path, name: str, text: str) -> Path:
    (folder / name).write_text(text)
    return folder / name


def centroid(*, scale: float = 1.0, places: Mapping[str, tuple[float, float]] | None = None, head: str = "") -> str:
    rows = (
        f"{name},{PACKAGES.get(name, 'R_0603')},{x * scale:.4f},{y * scale:.4f},0,{'bottom' if name == 'R2' else 'top'}"
        for name, (x, y) in (places or PLACES).items()
    )
    return "\n".join([head or "RefDes,Package,X,Y,Rotation,Layer", *rows]) + "\n"


def middles(board: Board) -> dict[str, tuple[float, float, str]]:
    sides = {each.name: each.side for each in board.components}
    found = {}
    for body in board.bodies:
        if body.role == "component":
            plan = body.patches.reshape(-1, 3)[:, :2]
            x, y = ((plan.min(axis=0) + plan.max(axis=0)) / 2).round(1).tolist()
            found[body.name] = (x, y, sides[body.name])
    return found


RIGHT = {name: (x, y, "bottom" if name == "R2" else "top") for name, (x, y) in PLACES.items()}


def rules(board: Board) -> set[str]:
    return {finding.rule.id for finding in board.findings}


BILLS = {
    "jlc": 'Comment,Designator,Footprint\n10k,"R1,R2, R3-R4",R_0805\nopamp,U1,SOIC-8\n',
    "altium": "Designator\tComment\tQuantity\tHeight (mm)\nR1, R2, R3, R4\t10k\t4\t0.5\nU1\topamp\t1\t1.7\n",
    "orcad": "Item;Quantity;Reference;Part Number\n1;4;R1,R2,R3,R4;RC0603\n2;1;U1;LM358\n",
}
