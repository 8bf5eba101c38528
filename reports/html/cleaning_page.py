"""A cleaning report, or two side by side, as one page of HTML that needs nothing else: to read, print and keep."""

from collections.abc import Iterable, Sequence
from html import escape

from boards.board import Workpiece
from cleaning.part_faces import FaceVerdict, weigh_faces
from cleaning.report import Traceability
from cleaning.uncertainty.comparison import Comparison
from cleaning.verdicts.results import (
    CleaningReport,
    Part,
    cleanliness,
    count_cleanliness,
    deciding_judgement,
    outcome,
    rank_parts,
    report_outcome,
    stays_wet,
    unclean_parts,
)
from cleaning.verdicts.rules import MISSED, OUTCOMES, UNDER_EXPOSED
from cleaning.verify import Verified
from programs.program import TimedProgram
from reports.cards.cleaning import face_tables, faces_card
from reports.cards.measured import hit_words, measured_blocks, rinse_table, rinse_words, source_words
from reports.cards.workpiece import part_facts
from reports.html.page import blocks_html, header, image, quiet, section, table_html, verdict_mark, whole_page
from reports.pictures import cleaning_pictures as pictures
from reports.pictures.gap_picture import draw_gaps
from reports.pictures.sheet import ACCENT
from reports.tables import cleaning_tables as tables
from reports.tables.comparison import Row, comparison_tables
from reports.tables.similar_components import group_alike, unclean
from reports.tables.table import FactList, Text
from reports.tables.wording import clock

MOST_DESCRIBED = 100
"""Groups of components that are described; the others that are not clean are named."""
_MOST_CLOSE = 6
_MOST_LIMITED = 15

_CLOSE_NOTE = (
    '<p class="q">Where the surface decides: what lands on it or flows over it, in multiples of what is needed; '
    f'walls are not seen from above; <span style="color:{ACCENT}">this colour</span> marks what the jet never hits. '
    "Where the gap decides: pressure and flow as if only the side that drives most of it were pressed; grey are solder "
    "joints; the cross is the middle of the worst tenth; a gap whose height is not known is shown at both bounds. One "
    "part of each package is shown.</p>"
)


def cleaning_page(
    report: CleaningReport,
    trace: Traceability,
    verified: Sequence[Verified] = (),
    producer: tables.Producer | None = None,
    measured: tuple[Comparison, Sequence[str]] | None = None,
) -> str:
    """Write the page; the same report and the same entries give the same text.

    Args:
        report: Result of the analysis.
        trace: What was entered about this board and its bath.
        verified: Components that were worked out exactly besides.
        producer: By what the analysis was made; ``None`` where that is not known.
        measured: Comparison with measurements, and the command for each of its recalibrations; ``None`` for none.
    """
    origin = report.origin
    grades = "; ".join(f"{grade}: {words}" for grade, words in tables.GRADES.items())
    limits = pictures.draw_limiting([part for part in rank_parts(report) if part.limiting][:_MOST_LIMITED])
    by = "" if producer is None else quiet(f"Analysed by {producer}.")
    note = quiet("How strongly the residue depends on each factor; the strongest is marked.")
    sections = [
        head_html(report),
        section("What was measured", "" if measured is None else _measured(*measured)),
        section(
            "The process",
            table_html(tables.stage_table(report, bare_board=True)),
            blocks_html(
                [*tables.renewals(report), *tables.surplus_words(report), *rinse_words(report), *tables.remarks(report)]
            ),
            table_html(rinse_table(report)),
        ),
        section("The board", legend(), *map(image, pictures.draw_verdicts(report))),
        section("Components, the worst first", components_html(report)),
        section("The process and the bare board", table_html(tables.process_table(report), "parts")),
        section("The worst parts, closely", *_closely(report)),
        section("What limits them", *([] if limits is None else [note, image(limits)])),
        section("How sure that is", _capability(report)),
        section("What reaches the surface", *_surface(report)),
        section("Worked out exactly", table_html(tables.verified_table(verified))),
        section("The rules", table_html(tables.rules_table(report)), quiet(f"Grades. {grades}.")),
        section("Where it comes from", _entries_html(trace, _origins(report), by)),
        section("Limits of the model", f"<ul>{''.join(f'<li>{escape(text)}</li>' for text in tables.LIMITS)}</ul>"),
        section("All that was assumed", table_html(tables.assumptions_table(report), "small")),
    ]
    return whole_page(f"{origin.board} with {origin.recipe}: cleaning", sections)


def comparison_page(rows: Sequence[Row], reports: tuple[CleaningReport, CleaningReport], names: tuple[str, str]) -> str:
    """Write the page; the same reports give the same text.

    Args:
        rows: What is compared.
        reports: What each cleans, on the same board.
        names: Name of each.
    """
    here = reports[0]
    one, other = names
    title = f"{one} and {other}"
    verdicts = "".join(
        f'<p><span class="mark" style="background:{pictures.VERDICT_COLOURS[report_outcome(report)]}"></span>'
        f"<b>{escape(name)}</b> {escape(tables.headline(report))}</p>"
        for name, report in zip(names, reports, strict=True)
    )
    worth = f'{verdicts}<p class="caveat">{escape(tables.caveat(here))}</p>'
    head = header(here.origin.board, title, "currentcolor", (), worth)
    compared = [section(table.title, table_html(table, "both")) for table in comparison_tables(rows, names)]
    boards = [
        section(f"{name}: the board", legend(), *map(image, pictures.draw_verdicts(report)))
        for name, report in zip(names, reports, strict=True)
    ]
    board, recipe, parameters = _origins(here)
    traces = section("Where it comes from", hash_lines([board, recipe, _origins(reports[1])[1], parameters]))
    return whole_page(f"{here.origin.board}: {title}", [head, *compared, *boards, traces])


def head_html(report: CleaningReport) -> str:
    """Write the headline, what it is worth, and the few numbers to know first."""
    origin = report.origin
    counts, wet = count_cleanliness(report.parts), tables.wet_count(report)
    litres = sum(value for _, value in report.litres)
    facts = [
        (clock(report.duration_s), "for the whole program"),
        (f"{litres:.2f} l", ", ".join(f"{name} {value:.2f}" for name, value in report.litres) or "no liquid"),
        *((str(count), tables.VERDICT_WORDS[verdict].removeprefix("is ")) for verdict, count in counts.items()),
        *([(str(wet), tables.wet_words(wet))] if wet else []),
    ]
    cards = "".join(f"<div><b>{escape(value)}</b><span>{escape(what)}</span></div>" for value, what in facts)
    worth = f'<p class="caveat">{escape(tables.caveat(report))}</p><div class="facts">{cards}</div>'
    colour = pictures.VERDICT_COLOURS[report_outcome(report)]
    above, cause = f"{origin.board} with {origin.recipe}", [tables.main_cause(report)]
    return header(above, tables.headline(report), colour, cause, worth)


def legend() -> str:
    """Name the colours in which components are drawn."""
    return f'<p class="legend">{" ".join(map(verdict_mark, OUTCOMES))}</p>'


def components_html(report: CleaningReport) -> str:
    """List the components that are not clean, the worst first, similar ones in one row; then name the others."""
    groups = group_alike(unclean_parts(report), unclean)
    html = table_html(tables.parts_table(report, groups[:MOST_DESCRIBED]), "parts")
    dry = " and dry" if any(map(stays_wet, report.parts)) else ""
    lists = {
        "Neither are these clean": [name for group in groups[MOST_DESCRIBED:] for name in group.names],
        f"Predicted clean{dry}": [part.component for part in report.parts if part.verdict == "clean"],
        "Avoided by a mask": [part.component for part in report.parts if part.verdict == "avoided"],
    }
    for title, names in lists.items():
        if names:
            html += f'<p class="names"><b>{title} ({len(names)}):</b> {escape(", ".join(names))}.</p>'
    return html


def _closely(report: CleaningReport) -> list[str]:
    """Draw the worst parts by what decides: what reaches them, or the gap under them; one part of each package.

    What is clean, or clean and wet, is drawn only where nothing else is worse; a part that no stage acts on is not.
    """
    packages = {component.name: component.package or component.name for component in report.board.components}
    parts = rank_parts(report)
    shown: dict[str, str] = {}
    not_clean = [each for each in parts if cleanliness(each) not in ("clean", "avoided")]
    for part in not_clean or [each for each in parts if each.gaps][:1]:
        kind = packages.get(part.component, part.component)
        if len(shown) < _MOST_CLOSE and kind not in shown and (html := _close_html(report, part)):
            shown[kind] = html
    return [_CLOSE_NOTE, *shown.values()] if shown else []


def _close_html(report: CleaningReport, part: Part) -> str:
    """Draw one part by the rule that decides; nothing where there is nothing to draw."""
    decides = deciding_judgement(part)
    title = (
        f"<h3>{escape(part.component)} {verdict_mark(outcome(part))} {escape(f'{decides.rule.id} {decides.name}')}</h3>"
    )
    if decides.rule in (MISSED, UNDER_EXPOSED):
        picture = pictures.draw_reach(report, part)
        return "" if picture is None else f"<article>{title}{image(picture)}</article>"
    if part.underside is None or not any(act is not None for gap in part.gaps for act in gap.stages):
        return ""
    known = f"{part.underside.gap_height_source}; {part.underside.joints_source}"
    drawn = image(draw_gaps(report, part)) + table_html(tables.gap_table(report, part))
    return f"<article>{title}{quiet(f'standoff and joints: {known}')}{drawn}</article>"


def _capability(report: CleaningReport) -> str:
    words = tables.capability_words(report)
    note = (
        f"{words}. Each value lies within the range that the parameter set states for it; each set is judged by the "
        "limits, without the margin. The ranges are as good as who stated them."
    )
    return blocks_html([note]) + table_html(tables.capability_table(report), "sure") if words else ""


def _measured(found: Comparison, commands: Sequence[str]) -> str:
    made_up = Text("This table is marked as synthetic: made up, it proves nothing about a line.", "strong")
    blocks = (f"{hit_words(found)}.", *measured_blocks(found, commands))
    source = f"{escape(source_words(found))}. Full sha256: <code>{escape(found.table.sha256)}</code>"
    return blocks_html([*([made_up] if found.table.synthetic else []), *blocks]) + f'<p class="q">{source}</p>'


def _surface(report: CleaningReport) -> list[str]:
    note = (
        f'<p class="q">Exposed surfaces as seen from the top. <span style="color:{ACCENT}">This colour</span> marks '
        "what the jet never hits; a line on a scale marks the limit.</p>"
    )
    maps: list[str] = []
    for stage, picture in pictures.draw_exposures(report):
        title = f"{escape(stage.function)} <span class='q'>{escape(str(stage.made_by))}</span>"
        maps.append(f"<article><h3>{title}</h3>{image(picture)}</article>")
    curves = pictures.draw_volumes(report)
    return [note, *maps, *([] if curves is None else [image(curves)])]


def _origins(report: CleaningReport) -> list[tuple[str, str, str]]:
    """Board, recipe and parameter set of a report: what each is, its name, its hash."""
    origin = report.origin
    board, recipe = ("board", origin.board, origin.board_sha256), ("recipe", origin.recipe, origin.recipe_sha256)
    return [board, recipe, ("parameter set", report.parameters.parameters, report.parameters_sha256)]


def _entries_html(trace: Traceability, origins: Sequence[tuple[str, str, str]], by: str = "") -> str:
    """What an operator states, with blanks where nothing was entered, and what the report was made from."""
    entries = [
        ("Serial number", trace.serial), ("Date", trace.date), ("Detergent and lot", trace.detergent),
        ("Bath temperature, °C", trace.bath_c), ("Conductivity of the rinse water, µS/cm", trace.conductivity),
        ("Operator", ""),
    ]  # fmt: skip
    blanks = "".join(
        f"<div><span>{escape(name)}</span><b>{escape(value) or '&nbsp;'}</b></div>" for name, value in entries
    )
    program = [("program", "", trace.program_sha256)] if trace.program_sha256 else []
    return f'<div class="blanks">{blanks}</div>{by}{hash_lines([*program, *origins])}'


def faces_page(part: Workpiece, program: TimedProgram, verdicts: Sequence[FaceVerdict], trace: Traceability) -> str:
    """Write the verdicts on the faces of a part as one page.

    Args:
        part: The part.
        program: That was judged.
        verdicts: One for each face and template.
        trace: What an operator states.
    """
    origin, card = program.origin, faces_card(part.name, verdicts)
    takes = f"in {clock(program.totals.duration_s)} with {origin.recipe}"
    colour = pictures.VERDICT_COLOURS[weigh_faces(verdicts).verdict]
    origins = [("part", origin.board, origin.board_sha256), ("recipe", origin.recipe, origin.recipe_sha256)]
    sections = [
        header(takes, part.name, colour, [card.title, *card.blocks]),
        section("Faces", "".join(table_html(each) for each in face_tables(verdicts))),
        section("Part", blocks_html([FactList(part_facts(part))])),
        section("Traceability", _entries_html(trace, origins)),
    ]
    return whole_page(f"{part.name}: what its faces get", sections)


def hash_lines(hashes: Iterable[tuple[str, str, str]]) -> str:
    """List the inputs of a report: what each is, its name, its hash."""
    lines = "".join(
        f"<div>{escape(f'{what} {name}'.rstrip())} <code>{escape(sha)}</code></div>" for what, name, sha in hashes
    )
    return f'<div class="hashes">sha256 of what it was made from{lines}</div>'
