"""A cleaning report as one page of HTML that needs nothing else: to look at, print and keep."""

from collections.abc import Iterable, Sequence
from html import escape

from cleaning.parameters.provenance import assumptions_of
from cleaning.report import Traceability
from cleaning.verdicts.cleanliness import (
    OUTCOMES,
    count_cleanliness,
    outcome,
    rank_parts,
    report_cleanliness,
    report_outcome,
    stays_wet,
)
from cleaning.verdicts.results import CleaningReport, Part
from cleaning.verify import Verified
from reports.html.cleaning_tables import (
    assumptions_table,
    gap_table,
    parts_table,
    process_table,
    remarks,
    renewals,
    rules_table,
    stages_table,
    verdict_mark,
    verified_table,
)
from reports.pictures.cleaning_curves import draw_limiting, draw_volumes
from reports.pictures.cleaning_pictures import VERDICT_COLOURS, draw_exposures, draw_verdicts
from reports.pictures.gap_picture import draw_gaps
from reports.pictures.html_page import image, section, whole_page
from reports.pictures.sheet import ACCENT
from reports.tables.report_header import Made
from reports.tables.rule_texts import CALIBRATED, HONESTY, LIMITS, SYNTHETIC, UNCALIBRATED, VERDICT_WORDS
from reports.tables.summary import amount, clock

_MOST_GAPS = 6
_MOST_LIMITED = 15


def cleaning_page(
    report: CleaningReport, trace: Traceability, verified: Sequence[Verified] = (), made: Made | None = None
) -> str:
    """Write the page; the same report and the same entries give the same text.

    Args:
        report: What the analysis found.
        trace: What was entered about this board and its bath.
        verified: Components that were worked out exactly besides.
        made: By what it was found; ``None`` where that is not known.
    """
    origin = report.origin
    sections = [
        _head(report),
        section(
            "The process",
            stages_table(report),
            *(f"<p>{escape(text)}</p>" for text in (*renewals(report), *remarks(report))),
        ),
        section("The board", legend(), *map(image, draw_verdicts(report))),
        section("Components, the worst first", parts_table(report)),
        section("The process and the bare board", process_table(report)),
        section("Under the worst parts", *_gaps(report)),
        section("What limits them", *_limiting(report)),
        section("What reaches the surface", *_surface(report)),
        section("Worked out exactly", verified_table(verified)),
        section("The rules", rules_table(report)),
        section("Where it comes from", _traces(report, trace, made)),
        section("What this model cannot say", f"<ul>{''.join(f'<li>{escape(text)}</li>' for text in LIMITS)}</ul>"),
        section("All that was assumed", assumptions_table(report)),
    ]
    return whole_page(f"{origin.board} with {origin.recipe}: cleaning", sections)


def headline(report: CleaningReport) -> str:
    """Say in one sentence how clean the worst component is, never an average, and how many stay wet."""
    wet = wet_count(report)
    return f"Predicted: {_how_clean(report)}" + (f"; {wet} {_stay(wet)} wet underneath" if wet else "")


def _how_clean(report: CleaningReport) -> str:
    if not report.parts:
        return "no components to judge"
    worst = report_cleanliness(report)
    components = amount(len(report.parts), "component")
    if worst == "clean":
        return f"all of {components} clean"
    count = count_cleanliness(report.parts).get(worst, 0)
    verdict = "without verdict" if worst == "no verdict" else worst
    return f"{count} of {components} {verdict}" if count else f"{verdict}, for the process or the bare board"


def wet_count(report: CleaningReport) -> int:
    """Count the components under which water stays."""
    return sum(map(stays_wet, report.parts))


def wet_words(count: int) -> str:
    """Say what a number of components does that are not dried, and what helps."""
    return f"{_stay(count)} wet underneath: bake, or blow harder"


def _stay(count: int) -> str:
    return "stays" if count == 1 else "stay"


def honesty(report: CleaningReport) -> str:
    """Say what the verdict is worth."""
    known = {each.known for each in assumptions_of(report.parameters)}
    return " ".join([
        HONESTY, CALIBRATED if report.parameters.calibrated else UNCALIBRATED, *([SYNTHETIC] * ("synthetic" in known))
    ])  # fmt: skip


def _head(report: CleaningReport) -> str:
    origin = report.origin
    counts, wet = count_cleanliness(report.parts), wet_count(report)
    litres = sum(value for _, value in report.litres)
    facts = [
        (clock(report.duration_s), "for the whole program"),
        (f"{litres:.2f} l", ", ".join(f"{name} {value:.2f}" for name, value in report.litres) or "no liquid"),
        *((str(count), VERDICT_WORDS[verdict].removeprefix("is ")) for verdict, count in counts.items()),
        *([(str(wet), wet_words(wet))] if wet else []),
    ]
    cards = "".join(f"<div><b>{escape(value)}</b><span>{escape(what)}</span></div>" for value, what in facts)
    return (
        f'<header><p class="q">{escape(origin.board)} with {escape(origin.recipe)}</p>'
        f'<h1 style="border-color:{VERDICT_COLOURS[report_outcome(report)]}">{escape(headline(report))}</h1>'
        f'<p class="honest">{escape(honesty(report))}</p><div class="facts">{cards}</div></header>'
    )


def legend() -> str:
    """Name the colours in which components are drawn."""
    return f'<p class="legend">{" ".join(map(verdict_mark, OUTCOMES))}</p>'


def _gaps(report: CleaningReport) -> list[str]:
    """Draw the gaps of the worst parts, one of each package; while others are not, those that are clean need none."""
    parts = [part for part in rank_parts(report) if part.gaps]
    wanting: Sequence[Part] = [part for part in parts if part.verdict != "clean"] or parts[:1]
    told = [
        '<p class="q">Pressure and flow as if only the side that drives most of it were pressed; grey are solder '
        "joints; the cross is the middle of the worst tenth. A gap whose height is not known is shown at both bounds. "
        "One part of each package is shown.</p>"
    ]
    for part in _unlike(report, wanting)[:_MOST_GAPS]:
        known = "" if part.underside is None else f"{part.underside.gap_height_source}; {part.underside.joints_source}"
        told.append(
            f"<article><h3>{escape(part.component)} {verdict_mark(outcome(part))}</h3>"
            f'<p class="q">standoff and joints: {escape(known)}</p>{image(draw_gaps(report, part))}'
            f"{gap_table(report, part)}</article>"
        )
    return told if wanting else []


def _unlike(report: CleaningReport, parts: Sequence[Part]) -> list[Part]:
    """Keep the first of each package: what the others look like can be told from it."""
    packages = {component.name: component.package or component.name for component in report.board.components}
    firsts: dict[str, Part] = {}
    for part in parts:
        firsts.setdefault(packages.get(part.component, part.component), part)
    return list(firsts.values())


def _limiting(report: CleaningReport) -> list[str]:
    parts = [part for part in rank_parts(report) if part.limiting][:_MOST_LIMITED]
    picture = draw_limiting(parts)
    note = '<p class="q">How strongly the residue answers to each factor; the strongest is marked.</p>'
    return [] if picture is None else [note, image(picture)]


def _surface(report: CleaningReport) -> list[str]:
    note = (
        f'<p class="q">Exposed surfaces as seen from the top. <span style="color:{ACCENT}">This colour</span> marks '
        "what the jet never hits; a line on a scale marks the limit.</p>"
    )
    maps = [
        f"<article><h3>{escape(stage.function)} <span class='q'>{escape(stage.made_by)}</span></h3>{image(picture)}"
        "</article>"
        for stage, picture in draw_exposures(report)
    ]
    curves = draw_volumes(report)
    return [note, *maps, *([] if curves is None else [image(curves)])]


def _traces(report: CleaningReport, trace: Traceability, made: Made | None) -> str:
    origin = report.origin
    entries = [
        ("Serial number", trace.serial), ("Date", trace.date), ("Detergent and lot", trace.detergent),
        ("Bath temperature, °C", trace.bath_c), ("Conductivity of the rinse water, µS/cm", trace.conductivity),
        ("Operator", ""),
    ]  # fmt: skip
    blanks = "".join(
        f"<div><span>{escape(name)}</span><b>{escape(value) or '&nbsp;'}</b></div>" for name, value in entries
    )
    program = [("program", "", trace.program_sha256)] if trace.program_sha256 else []
    origins = hash_lines([
        *program, ("board", origin.board, origin.board_sha256), ("recipe", origin.recipe, origin.recipe_sha256),
        ("parameter set", report.parameters.parameters, report.parameters_sha256),
    ])  # fmt: skip
    by = "" if made is None else f'<p class="q">Analysed by {escape(str(made))}.</p>'
    return f'<div class="blanks">{blanks}</div>{by}{origins}'


def hash_lines(hashes: Iterable[tuple[str, str, str]]) -> str:
    """List what something was made from: what it is, its name, its hash."""
    lines = "".join(
        f"<div>{escape(f'{what} {name}'.rstrip())} <code>{escape(sha)}</code></div>" for what, name, sha in hashes
    )
    return f'<div class="hashes">sha256 of what it was made from{lines}</div>'
