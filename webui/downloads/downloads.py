"""Files that a page offers: the bytes that the command line would write, under portable names."""

import re
import threading
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from cleaning.parameters.model import Parameters
from cleaning.part_faces import weigh_faces
from programs.errors import ProgramError
from programs.export import AS_PLANNED, Variant, own_dialect
from reports.files.commissioning import commissioning_page, page_name
from reports.files.robot_programs import CellExport, export_tracked
from reports.files.write_run import picture_bytes, program_bytes, report_bytes
from reports.tables.wording import amount, shorten
from robotcell.cell.installation import installation_of
from rulesengine.planning.pipeline import Run
from specs.finding import Finding, blocking, worst_first
from specs.input_file import InputFile
from specs.progress import Progress, subprogress
from washboard.cleaned import Cleaned, FaceReport
from washboard.driven import judge_driven
from webui.downloads.program_text import Written, link_text, zip_bytes
from webui.page.evaluations import Analysed, Checked, Judged, check_program
from webui.page.session import Session, comparison_of

_ODD = re.compile(r"[^\w.+-]+")
KINDS: dict[str, tuple[str, str]] = {
    "Everything (ZIP)": (
        ".zip",
        "Program, report, picture and recipe; with a cell the robot's program; once analysed, the cleaning report.",
    ),
    "Program (.wash)": (".wash", "The timed program; washboard show reads it."),
    "Picture (PNG)": (".png", "Workpiece and paths on one sheet."),
    "Picture (SVG)": (".svg", "The same, to be enlarged or edited."),
    "Report (JSON)": (".json", "Totals, components or faces, and findings as data."),
    "Playback (HTML)": (".html", "One file that plays in any browser, without Washboard."),
    "Recipe (YAML)": (".yaml", "The recipe as it is edited now."),
    "Cleaning report (HTML)": ("-cleaning.html", "The cleaning prediction, to look at and print."),
    "Cleaning report (JSON)": ("-cleaning.json", "The same as data."),
}
"""Suffix and description of each file, by its name on the page."""
_CHECKING = 0.8
"""Share of the check in the work for a robot's program."""
_ROBOT = 0.8
"""Share of the robot's program in the work for a zip."""
_CLEANING_DATA = "-cleaning.json"
_CLEANING = ("-cleaning.html", _CLEANING_DATA)
_ONE_DRAWS = threading.Lock()
"""Matplotlib is made for one thread."""


@dataclass(frozen=True, slots=True)
class Download:
    """A file that the browser saves."""

    name: str
    content: bytes


def make_download(kind: str, session: Session, allowed: Collection[str], rate: float, progress: Progress) -> Download:
    """File of a session.

    Args:
        kind: One of ``KINDS``.
        session: The session.
        allowed: Rules whose errors do not forbid a program.
        rate: How many times faster than the robot a playback runs.
        progress: Receives the stage and the share done.

    Raises:
        ProgramError: there is no program of the recipe as it is now, or a finding forbids it.
        JobError: the robot's program cannot be written.
    """
    suffix, _ = KINDS[kind]
    if suffix == ".yaml":
        return Download(_recipe_name(session), session.document.text.encode())
    run = session.planned_run
    progress(f"writing {kind}", 0.0)
    if suffix.startswith("-cleaning"):
        content = _cleaning_report(session, run, suffix)
    elif suffix == ".html":
        from webui.downloads.recording import record

        content = record(session.played or run, rate, progress, session.check, _predicted(session)).encode()
    elif suffix == ".zip":
        content = zip_bytes(_everything(session, run, allowed, progress))
    else:
        content = _content(suffix, run, allowed)
    return Download(f"{_file_stem(run)}{suffix}", content)


def _everything(session: Session, run: Run, allowed: Collection[str], progress: Progress) -> dict[str, bytes]:
    """Files of a job by their name in the zip: all that there is of it, each as it is downloaded alone.

    Raises:
        ProgramError: a finding forbids a program, or no language is chosen for the robot.
        JobError: the robot's program cannot be written.
    """
    refuse_errors(run.findings, allowed)
    stem = _file_stem(run)
    made: RobotProgram | None = None
    files: dict[str, bytes] = {}
    about: dict[str, str] = {}
    if session.cell is not None:  # first, as it takes longest and may be refused
        made = make_program(session, _language_of(session), subprogress(progress, 0.0, _ROBOT))
        refuse_errors(made.findings, allowed)
        cell_file = Path(session.cell.root.mark.file)
        cell_name = f"cell-{plain_name(cell_file.stem)}.yaml"
        files[cell_name] = InputFile(cell_file, noun="cell").read()
        about[cell_name] = "the cell that it was written for"
        if made.checked.motion is not None:
            from reports.pictures.joint_picture import draw_joints

            with _ONE_DRAWS:
                files[f"{stem}-joints.png"] = draw_joints(made.checked.report, ".png")
                about[f"{stem}-joints.png"] = "joints over time, with their limits"
    progress("writing program, report and picture", _ROBOT)
    files |= {f"{stem}{suffix}": _content(suffix, run, allowed) for suffix in (".wash", ".json", ".png")}
    files[_recipe_name(session)] = session.document.text.encode()
    if session.current is not None:
        progress("writing the cleaning report", (1.0 + _ROBOT) / 2)
        written = _CLEANING if session.analysis is not None else (_CLEANING_DATA,)
        files |= {f"{stem}{suffix}": _cleaning_report(session, run, suffix) for suffix in written}
    if made is None:
        return files
    kinds = {f"{stem}{suffix}": description for suffix, description in KINDS.values()}
    described = {_recipe_name(session): KINDS["Recipe (YAML)"][1], **kinds, **about}
    return _robot_files(made, made.page(_verdicts(session), {name: described[name] for name in files})) | files


def _verdicts(session: Session) -> list[str]:
    """What is predicted of the workpiece: as planned and, where that was judged, as driven."""
    driven = [] if session.judged_now is None else [str(session.judged_now.verdict)[1:-1].capitalize()]
    return [*([predicted] if (predicted := _predicted(session)) else []), *driven]


def _predicted(session: Session) -> str:
    """What the analysis of the program predicts, in one line; empty where it was not analysed."""
    if session.analysis is not None:
        report = session.analysis.report
        clean, avoided = (sum(part.verdict == each for part in report.parts) for each in ("clean", "avoided"))
        of = f"{clean} of {len(report.parts)} components" + (f" ({avoided} avoided)" if avoided else "")
        return f"Predicted clean: {of}, worst verdict {report.verdict}"
    if session.face_analysis is None:
        return ""
    verdicts = session.face_analysis.verdicts
    clean = sum(each.verdict == "clean" for each in verdicts)
    return f"Predicted clean: {clean} of {len(verdicts)} faces; the part is {weigh_faces(verdicts).verdict}"


def _language_of(session: Session) -> str:
    """The language that was chosen for the robot of the cell, else that of its maker.

    Raises:
        ProgramError: none was chosen, and its maker is none of those whose languages are written.
    """
    assert session.cell is not None
    installation = installation_of(session.cell)
    try:
        return session.language or own_dialect(installation)
    except ProgramError:
        name = installation.robot
        raise ProgramError(f"robot {name} has no language of its own; choose one in the tab Program.") from None


def forbidding(findings: Sequence[Finding]) -> dict[str, int]:
    """Rules whose errors forbid a program, with the number of their findings, in their order."""
    return dict(Counter(finding.rule.id for finding in blocking(findings, ())))


def _cleaning_report(session: Session, run: Run, suffix: str) -> bytes:
    """Report of the analysis as ``washboard analyse`` writes it; it states the fingerprint of the planned program.

    Raises:
        ProgramError: the program was not analysed.
    """
    from washboard.cleaned import Cleaned

    analysis = session.current
    if analysis is None:
        which = "" if run.workpiece.faces else " with these parameters"
        raise ProgramError(f"this program was not analysed{which}; press Analyse in the tab Cleaning.")
    measured = comparison_of(session)
    if isinstance(analysis, Analysed):
        done = Cleaned(analysis.report, program_bytes(run), analysis.effort)
    else:
        done = Cleaned(analysis, program_bytes(run))
    if suffix == _CLEANING_DATA:
        return done.data(measured=measured)
    with _ONE_DRAWS:
        return done.html(measured=measured).encode()


def _content(suffix: str, run: Run, allowed: Collection[str]) -> bytes:
    match suffix:
        case ".wash":
            refuse_errors(run.findings, allowed)
            return program_bytes(run)
        case ".json":
            return report_bytes(run)
        case _:
            with _ONE_DRAWS:
                return picture_bytes(run, suffix)


def refuse_errors(findings: Sequence[Finding], allowed: Collection[str]) -> None:
    """Refuse a program whose findings forbid it.

    Args:
        findings: All of them.
        allowed: Rules whose errors do not forbid a program.

    Raises:
        ProgramError: an error is left.
    """
    stops = blocking(findings, tuple(allowed))
    if stops:
        first = stops[0]
        raise ProgramError(
            f"{amount(len(stops), 'finding')} of severity error forbid{'s' if len(stops) == 1 else ''} the program. "
            f"First {first.rule.id} at {shorten(str(first.made_by)) or 'the board'}: {shorten(first.message)} "
            "Correct it, or tick its rule below the button to write the program in spite of it."
        )


def plain_name(name: str) -> str:
    """A name reduced to characters that are valid in file names everywhere."""
    return _ODD.sub("-", name).strip("-.")[:80] or "board"


@dataclass(frozen=True, slots=True, eq=False)
class RobotProgram:
    """A robot's program and its check."""

    checked: Checked
    written: Written

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Findings of plan, check and export, worst first."""
        return worst_first((*self.checked.run.findings, *self.checked.findings, *self.written.exported.findings))

    def page(self, verdicts: Sequence[str] = (), beside: Mapping[str, str] | None = None) -> str:
        """Write what an integrator has to do for it."""
        exported = self.written.exported
        return commissioning_page(self.checked.report, exported, self.findings, verdicts=verdicts, beside=beside)


def make_program(session: Session, dialect: str, progress: Progress, variant: Variant = AS_PLANNED) -> RobotProgram:
    """Write the program of a session for the robot of its cell, after a check where there is none.

    Raises:
        JobError: there is no such program yet, or it cannot be written.
    """
    cell = session.cell
    if cell is None:
        raise ProgramError("no cell is chosen; choose one in the tab Robot.")
    run = session.planned_run
    checked = session.check or check_program(run, cell, subprogress(progress, 0.0, _CHECKING))
    progress("writing", _CHECKING)
    return RobotProgram(checked, link_text(dialect, export_tracked(checked.report, cell, dialect, variant).exported))


def judge_program(made: RobotProgram, session: Session, parameters: Parameters, progress: Progress) -> Judged:
    """Judge what a robot's program cleans as its controller drives it, beside the plan.

    Args:
        made: The program.
        session: Its session; what was analysed of the plan with these parameters is not analysed again.
        parameters: Those of the session.
        progress: Receives the stage and the share done.

    Raises:
        JobError: the robot cannot carry it out, or it cannot be analysed.
    """
    if made.written.exported.motion.first_run:
        raise ProgramError("no jet is on in a first run, so it has no verdict; clear First run.")
    checked, known = made.checked, session.analysed
    if not checked.report.possible:
        raise ProgramError("the robot cannot carry the program out, so nothing is driven; its findings state why.")
    planned = None
    if isinstance(known, FaceReport) and known.program is checked.run.program:
        planned = Cleaned(known, b"")
    elif isinstance(known, Analysed) and known.prepared is not None and known.prepared.parameters == parameters:
        planned = (
            known.prepared
            if known.program is not checked.run.program
            else Cleaned(known.report, b"", known.effort, (), known.prepared)
        )
    done = CellExport(checked.report, made.written.exported)
    verdict = judge_driven(checked.run, done, parameters, progress, planned=planned)
    return Judged(checked, session.parameters_name, verdict)


def download_program(made: RobotProgram, allowed: Collection[str]) -> Download:
    """Pack a program and its page for commissioning; the same program gives the same bytes.

    Args:
        made: The program.
        allowed: Rules whose errors do not forbid it.

    Raises:
        ProgramError: a finding forbids it.
    """
    refuse_errors(made.findings, allowed)
    return Download(
        f"{_file_stem(made.checked.run)}-{made.written.dialect}.zip", zip_bytes(_robot_files(made, made.page()))
    )


def _robot_files(made: RobotProgram, page: str) -> dict[str, bytes]:
    """Files of a robot's program and its page by name, in the folder that their language has them in."""
    exported = made.written.exported
    texts = {page_name(exported.files): page, **exported.files}
    folder = exported.language.folder(exported.files)
    return {f"{folder}/{name}" if folder else name: text.encode() for name, text in texts.items()}


def _recipe_name(session: Session) -> str:
    return f"{plain_name(session.document.file.stem)}.yaml"


def _file_stem(run: Run) -> str:
    return f"{plain_name(run.workpiece.name)}-{plain_name(run.recipe.recipe)}"
