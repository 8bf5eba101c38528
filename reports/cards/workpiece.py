"""A board or a part as it was understood, the classes of components, and what was made of two silhouettes."""

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from boards.board import STATED_HEIGHT, Board, Component, Face, Instance, Workpiece, assumed_heights
from boards.formats.names import some
from boards.packages.undersides import STATED, UNKNOWN
from boards.undersides.underside import undersides_of
from reports.tables.run_report import FaceResult, hiders_of, share_of
from reports.tables.table import Block, Card, Column, FactList, Facts, FindingList, Table, Text, more_words
from reports.tables.wording import amount
from rulesengine.strokes.classify import Classified
from specs.finding import Finding

if TYPE_CHECKING:
    from boards.part.scan import Scan
    from rulesengine.surface.part_job import Survey

_GUESSED = " *"
_WIDEST_NAME = 24
_MOST_CONTRADICTIONS = 20
_MOST_HEIGHTS = 20
_LATER = "\N{HORIZONTAL ELLIPSIS}"


def workpiece_card(workpiece: Workpiece, rows: int | None = None) -> Card:
    """Show a board, or a part without what can be seen of its faces."""
    return part_card(workpiece) if workpiece.faces else board_card(workpiece.require_board("a card of a board"), rows)


def board_card(board: Board, rows: int | None = None) -> Card:
    """Show what was understood of a board, its components, its findings.

    Args:
        board: The board.
        rows: How many components to list; all of them without.
    """
    listed = board.components[:rows]
    blocks: list[Block] = [
        FactList(board_facts(board)),
        *_order_tables(board),
        *_open_heights(board),
        _components(listed),
    ]
    if 0 < len(listed) < len(board.components):
        more = amount(len(board.components) - len(listed), "more component")
        blocks.append((Text(f"and {more}", "quiet"), "; --all lists them"))
    if any(_is_guessed(component) for component in listed):
        note = "* from the package family; state standoffs in the board file or a parts table"
        blocks.append(Text(note, "quiet"))
    return Card(Text(board.name, "strong"), (*blocks, FindingList(board.findings)))


def _order_tables(board: Board) -> list[Block]:
    """Which file of an order states what, and what contradicts what; nothing for a board that came alone."""
    if not board.sources:
        return []
    files = [(each.name, each.kind, each.states) for each in board.sources]
    found = [
        (each.component, each.about, f"{each.taken} ({each.source})", f"{each.other} ({each.other_source})")
        for each in board.contradictions[:_MOST_CONTRADICTIONS]
    ]
    more = more_words(len(board.contradictions) - len(found), "contradictions")
    columns = (Column("file", at_least=12), "read as", "states")
    against = (
        [Table.of((_name_column([each[0] for each in found]), "about", "taken", "contradicts"), found)] if found else []
    )
    return [Table.of(columns, files, "order"), *against, *([more] if more else [])]


def _open_heights(board: Board) -> list[Block]:
    """Heights that nothing states, those first that matter most to a plan; nothing where all are stated."""
    found = assumed_heights(board.components)
    rows = [(key, f"{own[0].height_mm:g}", some([each.name for each in own])) for key, own in found[:_MOST_HEIGHTS]]
    more = more_words(len(found) - len(rows), "packages")
    columns = ("package", ">assumed\nmm", "components")
    title = "heights to state, under heights_mm in columns.yaml"
    return [Table.of(columns, rows, title), *([more] if more else [])] if rows else []


def _size(board: Board) -> str:
    x_min, y_min, x_max, y_max = board.outline.bounds
    return f"{x_max - x_min:.2f} x {y_max - y_min:.2f} mm"


def _board_counts(board: Board) -> Facts:
    """How many boards a panel has, with the numbers of each kind; nothing of a single board."""
    kinds: dict[tuple[str, ...], list[Instance]] = {}
    for each in board.instances:
        kinds.setdefault(tuple(sorted(part.name for part in each.board.components)), []).append(each)
    if len(kinds) < 2:
        return [("boards", f"{len(board.instances)} of one kind")] if kinds else []
    words = [
        f"{some([each.name for each in own])} ({_size(own[0].board)}, "
        f"{amount(len(own[0].board.components), 'component')})"
        for own in kinds.values()
    ]
    return [("boards", f"{len(board.instances)} of {len(kinds)} kinds: {'; '.join(words)}")]


def board_facts(board: Board) -> Facts:
    """What was understood of a board, in words."""
    x_min, y_min, _, _ = board.outline.bounds
    top = [component for component in board.components if component.side == "top"]
    tallest = max(board.components, key=lambda component: component.height_mm, default=None)
    joints = [underside.joints_source for underside in undersides_of(board)]
    known = (next(word for word in ("board file", "family", "unknown") if word in source) for source in joints)
    sources = _count_words(component.gap_height_source.split(" ")[0] for component in board.components)
    facts = [
        ("size", f"{_size(board)}, {board.top_z_mm - board.bottom_z_mm:.2f} mm thick"),
        ("outline", f"{board.outline.area / 100:.1f} cm2, {len(board.outline.interiors)} holes and slots"),
        ("surfaces", f"top at z = {board.top_z_mm:z.3f} mm, bottom at z = {board.bottom_z_mm:z.3f} mm"),
        ("origin", f"front left corner of the outline at x = {x_min:z.2f}, y = {y_min:z.2f} mm"),
        *_board_counts(board),
        ("components", f"{len(board.components)} ({len(top)} top, {len(board.components) - len(top)} bottom)"),
        ("patches", str(sum(len(body.patches) for body in board.bodies))),
        ("standoff", sources or "no components"),
        ("undersides", f"{len(joints)} thin gaps, joints: {_count_words(known)}" if joints else "no thin gaps"),
        ("sha256", board.sha256[:16]),
    ]
    if tallest is not None:
        facts.append(("tallest", f"{tallest.name}, {tallest.height_mm:.2f} mm"))
    heights = [component.height_source.split(" ")[0].rstrip(",") for component in board.components]
    if {*heights} - {STATED_HEIGHT}:
        facts.append(("heights", _count_words(heights)))
    fixtures = sum(body.role == "fixture" for body in board.bodies)
    return [*facts, *([("fixtures", str(fixtures))] if fixtures else [])]


def _count_words(words: Iterable[str]) -> str:
    return ", ".join(f"{count} {word}" for word, count in Counter(words).most_common())


def classes_card(
    components: Iterable[Component], classified: Sequence[Classified], findings: tuple[Finding, ...]
) -> Card:
    """Show which class takes each component and why, in the order of the board."""
    rows = [
        (each.component, component.package, each.component_class, each.because)
        for each, component in zip(classified, components, strict=True)
    ]
    name = _name_column([each.component for each in classified])
    return Card("", (Table.of((name, Column("package", at_most=32), "class", "because"), rows), FindingList(findings)))


def _components(components: Sequence[Component]) -> Table:
    rows: list[tuple[str, ...]] = []
    for each in components:
        height = "unknown" if each.gap_height_mm is None else f"{each.gap_height_mm:.3f}"
        mark = _GUESSED if each.gap_height_mm is not None and _is_guessed(each) else " " * len(_GUESSED)
        nearest = [(f"{distance:.2f}", name) for name, distance in each.neighbours[:1]] or [("", "")]
        rows.append((
            each.name, each.package, each.side, str(each.pins), f"{each.area_mm2:.2f}", f"{each.height_mm:.2f}",
            height + mark, *nearest[0],
        ))  # fmt: skip
    measures = (">pins", ">area\nmm2", ">height\nmm", ">standoff\nmm", ">nearest\nmm", "\nto")
    return Table.of((_name_column([each.name for each in components]), "package", "side", *measures), rows)


def _name_column(names: Iterable[str]) -> Column:
    """A first column that never gives way to a package's long name."""
    return Column("component", at_least=min(max(map(len, names), default=0), _WIDEST_NAME))


def _is_guessed(component: Component) -> bool:
    return component.gap_height_source not in (STATED, UNKNOWN)


def part_facts(part: Workpiece) -> Facts:
    """What was understood of a part, in words."""
    low, high = part.box
    served = [face for face in part.faces if face.serve]
    patches = sum(len(body.patches) for body in part.bodies if body.role == "part")
    area = sum(face.area_mm2 for face in part.faces)
    fixtures = [body.name for body in part.bodies if body.role == "fixture"]
    return [
        ("size", " x ".join(f"{each:.2f}" for each in (high - low).tolist()) + " mm"),
        ("patches", str(patches)),
        ("faces", f"{len(part.faces)}, {len(served)} of them sprayed, {sum(not each.flat for each in served)} curved"),
        ("area", f"{area / 100:.1f} cm2, {sum(face.area_mm2 for face in served) / 100:.1f} of them sprayed"),
        ("fixtures", ", ".join(fixtures) or "none"),
        ("sha256", part.sha256[:16]),
    ]


def part_card(part: Workpiece, survey: "Survey | None" = None, recipe: str = "") -> Card:
    """Show a part: size, faces, what a free pose of the nozzle can see of each, findings."""
    facts, tables = [*part_facts(part)], list[Table]()
    if survey is not None:
        every = survey.cell_face >= 0
        share = share_of(survey.cells.areas_mm2, survey.visible, every)
        seen = f"{share:.1%} of the sprayed faces, by any free pose" + (f" with {recipe}" if recipe else "")
        facts.append(("visible", seen))
        tables.append(_faces(part, survey))
    return Card(Text(part.name, "strong"), (FactList(facts), *tables, FindingList(part.findings)))


def _faces(part: Workpiece, survey: "Survey") -> Table:
    """A row for each face: kind, normal, area, the share that can be seen, and what hides the rest."""
    rows: list[tuple[str, ...]] = []
    for number, face in enumerate(part.faces):
        seen, hiders = "", ""
        if face.serve:
            own = survey.cell_face == number
            seen = f"{share_of(survey.cells.areas_mm2, own & survey.visible, own):.1%}"
            hiders = ", ".join(hiders_of(part, survey.cells.areas_mm2, own & ~survey.visible, survey.hider))
        served = "yes" if face.serve else "no"
        rows.append((face.name, kind_of(face), normal_of(face), f"{face.area_mm2:.0f}", served, seen, hiders))
    return Table.of(("face", "kind", "normal", ">area\nmm2", "sprayed", ">visible", "hidden by"), rows)


def component_card(
    component: Component, known: Classified | None, served: Facts, findings: tuple[Finding, ...]
) -> Card:
    """Show one component: what it is and where, which passes serve it, what was found about it.

    Args:
        component: The component.
        known: Its class; ``None`` before there is a run.
        served: What a run does to it.
        findings: About it.
    """
    x_min, y_min, x_max, y_max = component.footprint.bounds
    gap, source = component.gap_height_mm, component.height_source
    near = [f"{name}, {distance:.2f} mm" for name, distance in component.neighbours[:3]]
    facts = [
        ("package", component.package or "unknown"),
        ("value", component.value),
        ("class", _LATER if known is None else known.component_class),
        ("because", _LATER if known is None else known.because),
        ("size", f"{x_max - x_min:.2f} x {y_max - y_min:.2f} mm, {component.area_mm2:.1f} mm2"),
        (
            "height",
            f"{component.height_mm:.2f} mm, {component.side} side{'' if source == STATED_HEIGHT else f', {source}'}",
        ),
        ("pins", f"{component.pins}, {component.pins_source}"),
        ("standoff", "unknown" if gap is None else f"{gap:.3f} mm, {component.gap_height_source}"),
        ("neighbours", "\n".join(near) or "none on its side"),
        *served,
    ]
    known_facts = FactList([(name, value) for name, value in facts if value])
    return Card(Text(component.name, "strong"), (known_facts, *_found(findings)))


def face_card(face: Face, results: Sequence[FaceResult], findings: tuple[Finding, ...]) -> Card:
    """Show one face of a part: what it is, what each template of a plan does to it, what was found about it."""
    facts = [
        ("kind", kind_of(face)),
        ("normal", normal_of(face)),
        ("area", f"{face.area_mm2:,.0f} mm2"),
        ("sprayed", "yes" if face.serve else "no, the part file leaves it out"),
    ]
    for number, each in enumerate(results, start=1):
        words = [
            f"{each.pieces} stripes and pauses, {each.spray_s:.1f} s",
            f"tilted by at most {each.most_tilt_deg:.1f}\N{DEGREE SIGN}",
            f"{each.held_share:.1%} of what can be seen is held",
            *([f"{1 - each.visible_share:.1%} is hidden by {', '.join(each.hidden_by)}"] if each.hidden_by else []),
        ]
        facts.append((f"plan {number}" if number > 1 else "plan", "\n".join(words)))
    return Card(Text(face.name, "strong"), (FactList(facts), *_found(findings)))


def _found(findings: tuple[Finding, ...]) -> tuple[FindingList, ...]:
    """Findings about a place; a place without any needs no remark."""
    return (FindingList(findings),) if findings else ()


def kind_of(face: Face) -> str:
    """Kind of a face in a word."""
    return "plane" if face.flat else "curved"


def normal_of(face: Face) -> str:
    """Normal of a face, such as ``0.00, 0.71, 0.71``."""
    return ", ".join(f"{each:z.2f}" for each in face.normal)


def scan_card(scan: "Scan") -> Card:
    """Show what two silhouettes gave: size, volume, how far its outlines are from theirs, findings."""
    bodies = {
        "revolution": "a body of revolution about the upright axis",
        "extrusion": "an extrusion along one of the views",
        "mirror": "rectangular sections, mirrored in both middle planes",
        None: "the hull of both views",
    }
    front, side = scan.off_px
    facts = [
        ("body", bodies[scan.symmetry]),
        *part_facts(scan.part),
        ("volume", f"{scan.volume_mm3 / 1000:.3f} cm3"),
        ("outline", f"within {front:.2f} pixels of the front view, {side:.2f} of the side view"),
    ]
    return Card("", (FactList(facts), FindingList(scan.part.findings)))
