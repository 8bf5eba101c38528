"""What a program cleans: of a board, of one component, of the faces of a part; and of two programs side by side."""

from collections import Counter
from collections.abc import Sequence

from cleaning.parameters.provenance import assumptions_of
from cleaning.part_faces import CLEAN_SHARE, MARGINAL_SHARE, MISSED_SHARE, FaceVerdict, weigh_faces
from cleaning.part_film import FilmOnFace
from cleaning.process.stages import Stage
from cleaning.report import to_error
from cleaning.verdicts.results import (
    CleaningReport,
    Judgement,
    Part,
    deciding_judgement,
    outcome,
    parts_by_instance,
    report_outcome,
    unclean_parts,
)
from cleaning.verdicts.rules import VERDICTS
from reports.cards.measured import rinse_words
from reports.tables import cleaning_tables as tables
from reports.tables.comparison import Row, comparison_tables
from reports.tables.similar_components import deciding, group_alike
from reports.tables.table import Bar, Block, Card, Cell, FactList, Facts, Note, Table, Text, more_words, program_title
from reports.tables.wording import amount, clock, name_some, number_text, shorten

_MOST_GROUPS = 12
_MOST_NAMES = 12
_MOST_WORST = 3
_MOST_MAKERS = 6
_PARTS = ("component", "verdict", "grade", "rule", "because", "what to do")
_FACE_CAVEAT = (
    f"A face is clean where at least {CLEAN_SHARE:.0%} of what can be seen of it is in the cone for the required time, "
    f"marginal from {MARGINAL_SHARE:.0%}; the part by all its area, and not clean with a dirty face that lacks more "
    f"than {MISSED_SHARE:.1%} of it. Only exposure is judged: a part has no components and no gaps."
)


def cleaning_card(report: CleaningReport, analysed: str) -> Card:
    """Show headline and caveat, the stages, the worst components, what is wrong with the process, and what it rests on.

    Args:
        report: Result of the analysis.
        analysed: How it was made, such as ``"by Washboard 1.2"``.
    """
    title, caveats, findings = _headline(report, [("analysed", analysed)])
    groups = group_alike(unclean_parts(report), deciding)
    rows: list[tuple[Cell, ...]] = []
    for group in groups[:_MOST_GROUPS]:
        first, verdict = group.descriptions[0], Text(outcome(group.parts[0]), tone=outcome(group.parts[0]))
        names, rule = name_some(group.names, _MOST_NAMES), f"{first.rule} {first.name}"
        because = first.because or "; ".join(number_text(low, high) for low, high in first.numbers)
        rows.append((names, verdict, tables.grade_words(group.parts[0]), rule, because, first.advice))
    more = sum(len(group.parts) for group in groups[_MOST_GROUPS:])
    beyond = [f"and {amount(more, 'more component')}; --html and --json have all of them"] if more else []
    sure = [] if report.capability is None else [tables.capability_table(report, _MOST_NAMES)]
    return Card(title, (*caveats, tables.stage_table(report), Table.of(_PARTS, rows), *beyond, *findings, *sure))


def headline_card(report: CleaningReport, times: str) -> Card:
    """Show how clean the worst component is, and what that rests on; ``times`` states whose they are."""
    by_function = ", ".join(f"{name} {litres:.2f} l" for name, litres in report.litres)
    facts = [("sprayed", by_function or "nothing"), ("parameters", f"sha256 {report.parameters_sha256[:8]}")]
    title, caveats, findings = _headline(report, [*facts, ("analysed", f"with the times {times}")])
    return Card(title, (*caveats, *findings))


def _headline(report: CleaningReport, facts: Facts) -> tuple[tuple[str | Text, ...], list[Block], list[Block]]:
    """Title of a report, what it is worth, and what holds for the board and the process."""
    words = Text(tables.headline(report), tone=report_outcome(report))
    title = program_title(report.origin, ". ", words)
    caveats: list[Block] = [Text(tables.caveat(report), "quiet"), *filter(None, [tables.main_cause(report)])]
    wrong = (judgement_note(each, name) for name, each in tables.board_judgements(report) if each.verdict != "clean")
    sure = [f"{words}." for words in [tables.capability_words(report)] if words]
    return title, caveats, [*wrong, FactList([*_facts(report), *facts]), *sure]


def _facts(report: CleaningReport) -> Facts:
    assumed = assumptions_of(report.parameters)
    counts = ", ".join(f"{count} {word}" for word, count in Counter(each.known for each in assumed).items())
    wet, litres = tables.wet_count(report), sum(value for _, value in report.litres)
    return [
        ("components", tables.count_words(report.parts)),
        *((f"board {name}", tables.count_words(parts)) for name, parts in parts_by_instance(report).items()),
        *([("wet", f"{wet} {tables.wet_words(wet)}")] if wet else []),
        ("takes", f"{clock(report.duration_s)}, {f'{litres:.2f} l' if report.litres else 'no liquid'}"),
        ("assumed", f"{len(assumed)} values of {report.parameters.parameters}: {counts}"),
        *(("rinsed", each) for each in rinse_words(report)),
        *(("noted", shorten(each)) for each in tables.remarks(report)),
    ]


def worst_card(report: CleaningReport, seconds: float) -> Card:
    """Show headline and caveat, verdicts counted, the worst few with the reason, and how long the analysis took."""
    worst = group_alike(unclean_parts(report), deciding)[:_MOST_WORST]
    facts = [
        ("verdicts", tables.count_words(report.parts)),
        *((name_some(each.names, 1), f"{outcome(each.parts[0])}: {each.descriptions[0].because}") for each in worst),
        ("analysed", f"in {clock(seconds)}"),
    ]
    title = (Text(report.origin.board, "strong"), f", what comes out clean. {tables.headline(report)}")
    caveats = (Text(tables.caveat(report), "quiet"), *filter(None, [tables.main_cause(report)]))
    return Card(title, (*caveats, FactList(facts)))


def comparison_card(rows: Sequence[Row], report: CleaningReport, names: tuple[str, str]) -> Card:
    """Show the caveat, and one line for each quantity; what does not differ is quiet.

    Args:
        rows: What is compared.
        report: One of the two.
        names: Name of each.
    """
    title = (Text(report.origin.board, "strong"), " with ", Text(" and ".join(names), "strong"), ".")
    return Card(title, (Text(tables.caveat(report), "quiet"), *comparison_tables(rows, names)))


def stage_names(stages: Sequence[Stage]) -> tuple[str, ...]:
    """Names of stages: number and function, such as ``1 clean``."""
    return tuple(f"{number} {stage.function}" for number, stage in enumerate(stages, start=1))


def cleaned_component_card(report: CleaningReport, part: Part) -> Card:
    """Show one component: judgements, exposure by stage, limiting factors, strokes that spray it.

    The residue changes so much for one percent more of each factor: the longest bar limits most.
    """
    names = dict(zip((stage.made_by for stage in report.stages), stage_names(report.stages), strict=True))
    first, verdict = deciding_judgement(part), outcome(part)
    judgements = sorted(part.judgements, key=lambda each: each is not first)
    sampled = () if report.capability is None else report.capability.parts
    sure = [tables.sure_words(each) for each in sampled if each.component == part.component]
    longest = max([1e-9, *map(abs, part.elasticity.values())])
    factors = [
        (name, Bar(abs(value) / longest, f"{value:+z.2f} %", marked=name == part.limiting))
        for name, value in sorted(part.elasticity.items(), key=lambda item: -abs(item[1]))
    ]
    makers = [(shorten(str(maker)), f"{100 * share:.0f} %") for maker, share in part.makers[:_MOST_MAKERS]]
    title = Text(part.component, "strong"), " ", Text(tables.OUTCOME_WORDS[verdict], tone=verdict)
    return Card(
        (*title, Text(f" grade {tables.grade_words(part)}", "quiet")),
        (
            *(judgement_note(each, names.get(each.stage, "")) for each in judgements),
            *(Text(f"{words[:1].upper()}{words[1:]}.", "small") for words in sure),
            _exposure_table(part, report),
            Table.of(("", ""), factors, "What limits it: residue for 1 % more of it"),
            Table.of(("", ">"), makers or [("nothing", "")], "Sprayed by"),
            *more_words(len(part.makers) - _MOST_MAKERS),
        ),
    )


def judgement_note(judgement: Judgement, where: str) -> Note:
    """What a rule found, the numbers with their limits, the advice.

    Args:
        judgement: The judgement.
        where: Its stage, or what it is about; empty for a component in all stages together.
    """
    verdict = Text(judgement.verdict, tone=judgement.verdict)
    head = (f"{judgement.rule} {judgement.name}: ", verdict, f", grade {judgement.grade}{where and f', {where}'}")
    numbers = ", ".join(number_text(each) for each in judgement.numbers)
    below = Text(judgement.because), Text(judgement.advice, "strong"), Text(numbers, "small")
    return Note(judgement.verdict, head, tuple(each for each in below if each.text))


def _exposure_table(part: Part, report: CleaningReport) -> Table:
    """Exposure of the surface by stage: its least served places, peak pressure, share missed."""
    rows: list[tuple[str, ...]] = []
    for name, exposed in zip(stage_names(report.stages), part.exposed, strict=True):
        if exposed is None:
            rows.append((name, "other side", "", "", "", ""))
            continue
        cone, error = (to_error(value, exposed.cone_error_s) for value in (exposed.cone_s[2], exposed.cone_error_s))
        rows.append((
            name, f"{exposed.supply_mm[1]:.2f} mm", f"{exposed.front_s[1]:.2f} s", f"{cone:g} ± {error:g} s",
            f"{exposed.peak_pa:.0f} Pa", f"{100 * exposed.missed_share:.0f} %",
        ))  # fmt: skip
    headings = ("stage", ">with run-off", ">front", ">cone, mean", ">peak", ">missed")
    return Table.of(headings, rows, "Surface, the least-served places")


def faces_card(name: str, verdicts: Sequence[FaceVerdict]) -> Card:
    """Show the verdict on a part, what is short of its area, how many faces have which, and what they rest on."""
    found = weigh_faces(verdicts)
    worst = found.verdict
    counts = Counter(each.verdict for each in verdicts)
    words = ", ".join(f"{counts[verdict]} {verdict}" for verdict in VERDICTS if counts[verdict])
    title = (Text(name, "strong"), ": ", Text(worst, tone=worst), f", {counts['clean']} of {len(verdicts)} faces clean")
    short = f", {found.short_mm2:.0f} mm2 lack {found.lacking_s:.2f} s in the mean" if found.short_mm2 > 0 else ""
    if found.short_mm2 > 0 and found.lacking_s == 0:
        short = f", the film on {found.short_mm2:.0f} mm2 is beyond its tolerance"
    held = [("held", f"{found.held_share:.2%} of the visible area{short}")] if worst != "no verdict" else []
    return Card(title, (FactList([("faces", words), *held]), Text(_FACE_CAVEAT, "quiet")))


def face_verdict_table(verdicts: Sequence[FaceVerdict]) -> Table:
    """List the faces of a part by template: verdict, what is visible and held, and what hides the rest."""
    rows = [
        (
            each.face, Text(each.verdict, tone=each.verdict), f"{each.required_s:g}", f"{each.least_s:.2f}",
            f"{each.mean_s:.2f}", f"{each.visible_share:.1%}", f"{each.held_share:.1%}", f"{each.unseen_mm2:.0f}",
            ", ".join(each.hidden_by),
        )
        for each in verdicts
    ]  # fmt: skip
    headings = (">required\ns", ">least\ns", ">mean\ns", ">visible", ">held\nof it", ">unseen\nmm2", "hidden by")
    return Table.of(("face", "verdict", *headings), rows)


def film_table(verdicts: Sequence[FaceVerdict]) -> Table:
    """List the films on the faces of a part: what is required and laid, and how much is too thin or too thick."""
    rows = [
        (
            each.face, Text(each.verdict, tone=each.verdict), f"{film.thickness_um:g} ± {film.tolerance_um:g}",
            f"{film.least_um:.2f}", f"{film.mean_um:.2f}", f"{film.most_um:.2f}", f"±{film.deviation:.2%}",
            f"{film.within_share:.1%}", f"{film.thin_mm2:.0f}", f"{film.thick_mm2:.0f}",
        )
        for each in verdicts if (film := each.film) is not None
    ]  # fmt: skip
    films = (">film\nµm", ">least\nµm", ">mean\nµm", ">most\nµm", ">off by")
    return Table.of(("face", "verdict", *films, ">within", ">thin\nmm2", ">thick\nmm2"), rows, "Films")


def face_tables(verdicts: Sequence[FaceVerdict]) -> tuple[Table, ...]:
    """Times in the cone of the faces, and their films: those of the two that there are."""
    times = [each for each in verdicts if each.film is None]
    films = [each for each in verdicts if each.film is not None]
    return (*([face_verdict_table(times)] if times else []), *([film_table(films)] if films else []))


def _film_facts(film: FilmOnFace) -> list[tuple[str, str]]:
    places = (", ".join(f"{value:z.0f}" for value in place) for place in (film.thinnest, film.thickest))
    thin, thick = places
    return [
        ("film", f"{film.thickness_um:g} ± {film.tolerance_um:g} µm"),
        ("laid", f"{film.least_um:.2f} to {film.most_um:.2f} µm, mean {film.mean_um:.2f}, ±{film.deviation:.2%}"),
        (
            "within",
            f"{film.within_share:.1%}; too thin on {film.thin_mm2:,.0f}, too thick on {film.thick_mm2:,.0f} mm2",
        ),
        ("thinnest, thickest", f"at ({thin}), at ({thick})"),
    ]


def cleaned_face_card(each: FaceVerdict, template: str) -> Card:
    """Show the verdict on one face: required and measured times, what is not seen, and what hides it."""
    times = [
        ("required", f"{each.required_s:g} s in the cone"),
        ("held", f"{each.held_share:.1%} of what can be seen"),
        ("in the cone", f"least {each.least_s:.2f} s, mean {each.mean_s:.2f} s"),
    ]
    facts = [
        ("template", template),
        *(times if each.film is None else _film_facts(each.film)),
        ("visible", f"{each.visible_share:.1%} of {each.area_mm2:,.0f} mm2"),
        *([("hidden", f"{each.unseen_mm2:,.0f} mm2, by {', '.join(each.hidden_by)}")] if each.hidden_by else []),
    ]
    title = Text(each.face, "strong"), " ", Text(tables.OUTCOME_WORDS[each.verdict], tone=each.verdict)
    return Card(title, (FactList(facts),))
