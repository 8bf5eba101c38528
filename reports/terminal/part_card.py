"""A part as it was understood, and a run over it, for the terminal."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.console import Console

from boards.board import Part, Workpiece
from cleaning.part_faces import FaceVerdict, worst_verdict
from reports.tables.part_tables import covering_table, face_table, part_facts, share_of, verdict_table
from reports.terminal.console import STYLES, print_facts, print_findings, print_line, print_table
from reports.terminal.program_card import print_program
from specs.finding_rules import SURFACE_ORDER, SURFACE_REPAIR

if TYPE_CHECKING:
    from boards.part.scan import Scan
    from rulesengine.planning.pipeline import Run
    from rulesengine.surface.part_job import Covering, Survey


def print_part(console: Console, part: Part, survey: "Survey") -> None:
    """Print a part's card: size, faces, what can be seen of each, findings."""
    print_line(console, (part.name, "bold"))
    every = survey.cell_face >= 0
    seen = f"{share_of(survey.cells.areas_mm2, survey.visible, every):.1%} of the sprayed faces, by any free pose"
    print_facts(console, [*part_facts(part), ("visible", seen)])
    print_table(console, face_table(part, survey))
    print_findings(console, part.findings)


def print_scan(console: Console, scan: "Scan") -> None:
    """Print what two silhouettes gave: size, volume, how far its outlines are from theirs, findings."""
    bodies = {
        "revolution": "a body of revolution about the upright axis",
        "extrusion": "an extrusion along one of the views",
        "mirror": "rectangular sections, mirrored in both middle planes",
        None: "the hull of both views",
    }
    front, side = scan.off_px
    print_facts(
        console,
        [
            ("body", bodies[scan.symmetry]),
            *part_facts(scan.part),
            ("volume", f"{scan.volume_mm3 / 1000:.3f} cm3"),
            ("outline", f"within {front:.2f} pixels of the front view, {side:.2f} of the side view"),
        ],
    )
    print_findings(console, scan.part.findings)


def print_part_run(console: Console, run: "Run") -> None:
    """Print time and litres, what each template does to each face, the rounds of the repair, and findings."""
    print_program(console, run.program)
    quiet = (SURFACE_ORDER, SURFACE_REPAIR)
    for covering in run.coverings:
        print_line(console, (str(covering.made_by), "bold"))
        mine = [each for each in run.findings if each.made_by == covering.made_by and each.rule in quiet]
        facts = [("order" if each.rule == SURFACE_ORDER else "repair", each.message) for each in mine]
        uniform = f"{covering.uniform_share:.1%} of the visible area held, {covering.uniform_s:.1f} s of spraying"
        held = f"{covering.share:.1%} of the visible area is in the cone for {covering.required_s:g} s"
        print_facts(
            console, [*facts[:1], ("uniform", uniform), *facts[1:], ("held", held), ("bound", _bound(covering))]
        )
        print_table(console, covering_table(run.workpiece, covering))
    print_findings(console, [finding for finding in run.findings if finding.rule not in quiet])


def _bound(covering: "Covering") -> str:
    """The time of spraying beside the bound, and what that one rests on."""
    least = covering.least
    if least.seconds <= 0:
        return f"{covering.spray_s:.1f} s of spraying; no bound, since no pose of least tilt holds any of it"
    return (
        f"{covering.spray_s:.1f} s of spraying, {covering.spray_s / least.seconds:.2f} times the {least.seconds:.1f} s "
        f"of a bound over {least.poses} poses of least tilt, about {least.apart_mm:.0f} mm apart: an estimate, no proof"
    )


def print_faces(console: Console, part: Workpiece, verdicts: Sequence[FaceVerdict]) -> None:
    """Print the worst verdict, how many faces are clean, and a row for each face and template."""
    worst, clean = worst_verdict(verdicts), sum(each.verdict == "clean" for each in verdicts)
    print_line(console, (part.name, "bold"), ": ", (worst, STYLES[worst]), f", {clean} of {len(verdicts)} faces clean")
    print_table(console, verdict_table(verdicts))
