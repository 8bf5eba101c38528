"""The page beside a robot's program: what to load, set up, compare, check, and how to start it, in this order."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence

from programs.export import Exported
from programs.motion.analog import analog_channels
from programs.posts.dialect import PAGE_ENDING, Dialect, ProgramFiles, Task
from programs.posts.writing.frame import FIRST_RUN_ADVICE
from reports.tables.wording import clock
from robotcell.cell.cell_edits import place_of
from robotcell.cell.hold import describe_held
from robotcell.track import CellReport
from specs.errors import printable
from specs.finding import Finding

_CODE = 7 * " "


def page_name(files: Iterable[str]) -> str:
    """Name the page of a program, of the names of its files."""
    return f"{next(iter(files))}{PAGE_ENDING}"


def commissioning_page(
    report: CellReport,
    exported: Exported,
    findings: Sequence[Finding],
    *,
    verdicts: Sequence[str] = (),
    beside: Mapping[str, str] | None = None,
) -> str:
    """Write the page as Markdown; the same program gives the same text.

    Args:
        report: What the robot does with the program.
        exported: How that is written.
        findings: Of plan, check and export, worst first.
        verdicts: What is predicted of the workpiece; empty where it was not analysed.
        beside: What else is packed with the program: descriptions by the name of the file.
    """
    origin, given, language = exported.motion.origin, exported.handover, exported.language
    sections = {
        "Load": _load(exported.files, language, given.shared, beside or {}),
        "Left to do by hand": _tasks(given.tasks),
        "Compare with the real cell": _places(report, exported),
        "Signals": _signals(exported),
        "What the program does": _bullets((*_times(report, exported), *given.work, *given.remarks)),
        "Start": _start(exported),
        "What is known of it": _known(findings, verdicts),
    }
    lines = [
        f"# Commissioning of {next(iter(exported.files))}",
        "",
        f"{language.title}; workpiece {origin.board}, recipe {origin.recipe}, cell {report.cell.name}, robot "
        f"{report.cell.robot.name}. Millimetres and degrees where nothing else is stated.",
    ]
    for number, (title, body) in enumerate(sections.items(), start=1):
        lines += ["", f"## {number}. {title}", "", *body]
        lines = lines[:-1] if not lines[-1] else lines
    return "".join(f"{_plain(line)}\n" for line in lines)


def _plain(line: str) -> str:
    """Keep a text from being read as HTML; what is to be entered stays as it is."""
    return printable(line) if line.startswith(_CODE) else printable(line).replace("<", "\\<")


def _load(files: ProgramFiles, language: Dialect, shared: str, beside: Mapping[str, str]) -> Iterator[str]:
    main, *others = files
    folder = f", in the folder `{name}`" if (name := language.folder(files)) else ""
    yield f"- `{main}` is the file to start with{folder}."
    if others:
        yield f"- With it: {', '.join(f'`{each}`' for each in others)}."
    yield f"- {language.notes}"
    if shared:
        yield f"- Shared with other programs of this cell: {shared}. All else has names of its own."
    yield from (f"- Beside it `{name}`: {words[0].lower()}{words[1:].rstrip('.')}." for name, words in beside.items())


def _tasks(tasks: Sequence[Task]) -> Iterator[str]:
    """Number the tasks; what is to be entered stands as code."""
    for number, task in enumerate(tasks, start=1):
        yield f"{number}. {task.text[0].upper()}{task.text[1:]}{':' if task.lines else '.'}"
        if task.lines:
            yield from ("", *(f"{_CODE}{line}" for line in task.lines), "")
    if not tasks:
        yield "Nothing."


def _places(report: CellReport, exported: Exported) -> Iterator[str]:
    base, held = place_of(report.cell.T_cell_base), place_of(report.cell.held_pose)
    yield f"- The robot's base is at {_list(base.xyz_mm)} in the cell, roll, pitch and yaw {_list(base.rpy_deg)}."
    place = f"{_list(held.xyz_mm)}, roll, pitch and yaw {_list(held.rpy_deg)}"
    yield f"- The workpiece is held by its {describe_held(report.cell.held_by)}, which is at {place}."
    if home := exported.handover.home:
        yield f"- Home: {home}."
    frames, (names, meaning) = exported.handover.frames, exported.handover.angles
    yield f"- Tools are seen from the flange, the workpiece from the robot's base. {names}: {meaning}."
    yield ""
    rows = ((frame.kind, str(frame.number), frame.name, *frame.words, frame.load) for frame in frames)
    yield from _table(("frame", "number", "name", "X", "Y", "Z", *names.split(), "load"), rows)


def _signals(exported: Exported) -> Iterator[str]:
    yield from _table(
        ("", "name", "address", "what for"),
        (
            ("input" if each.is_input else "output", each.name, each.address, each.use)
            for each in exported.handover.signals
        ),
    )
    if analog := [*analog_channels(exported.motion.steps)]:
        yield ""
        yield from _bullets(f"Analog {exported.language.capability.analog.describe(channel)}" for channel in analog)


def _times(report: CellReport, exported: Exported) -> Iterator[str]:
    planned, done = report.requested.totals.duration_s, report.program.totals.duration_s
    yield f"Takes {clock(done)} as the robot moves, from home to home; the recipe alone takes {clock(planned)}"
    if exported.forecast is not None:
        yield f"Predicted: {exported.forecast.describe()}"


def _start(exported: Exported) -> Iterator[str]:
    steps = [
        "valves' supplies shut, by hand; nobody in the cell",
        "the robot near home: nothing knows what is beside it",
        *(
            (*exported.motion.first_run.split("; "), *FIRST_RUN_ADVICE)
            if exported.motion.first_run
            else (
                "first run: `washboard export` with `--first-run` writes the same motion, slow, with valves shut and a "
                "stop before each step; run that first",
                "then this program in manual mode, then in automatic with a hand on the stop, still without water",
                "each fault once: door, stop, emergency stop, override; the valves have to be shut after each",
                "then with water, and look at one workpiece before the next",
            )
        ),
    ]
    yield from (f"{number}. {step[0].upper()}{step[1:]}." for number, step in enumerate(steps, start=1))


def _known(findings: Sequence[Finding], verdicts: Sequence[str]) -> Iterator[str]:
    yield from _bullets(verdicts or ("Not analysed for cleanliness",))
    found = [each for each in findings if each.severity != "info"]
    counts = Counter(each.rule.id for each in found)
    firsts: dict[str, Finding] = {}
    for each in found:
        firsts.setdefault(each.rule.id, each)
    for rule, first in firsts.items():
        more = f", and {counts[rule] - 1} more" if counts[rule] > 1 else ""
        yield f"- {first.severity} `{rule}`{more}: {first.message}"
    if not found:
        yield "- No errors, no warnings."


def _bullets(lines: Iterable[str]) -> Iterator[str]:
    return (f"- {line}." for line in lines)


def _table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> Iterator[str]:
    """Write a table that reads well in an editor: columns as wide as their widest cell; empty ones are left out."""
    cells = [[printable(cell).replace("|", "\\|") for cell in row] for row in (header, *rows)]
    kept = [at for at, _ in enumerate(header) if any(row[at] for row in cells[1:])]
    widths = [max(len(row[at]) for row in cells) for at in kept]
    lines = [
        "| " + " | ".join(row[at].ljust(width) for at, width in zip(kept, widths, strict=True)) + " |" for row in cells
    ]
    rule = "|" + "|".join("-" * (width + 2) for width in widths) + "|"
    yield from (lines[0], rule, *lines[1:])


def _list(values: Sequence[float]) -> str:
    return ", ".join(f"{value:g}" for value in values)
