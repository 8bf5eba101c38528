"""A parameter set on the terminal: every value, how it is known, and where it was written."""

from pathlib import Path
from typing import Any

from rich.console import Console

from cleaning.parameters.consistency import value_paths
from cleaning.parameters.load import LoadedParameters, parameters_sha256
from reports.tables.table import Column, Table
from reports.terminal.console import print_line, print_source, print_table
from specs.yaml.located import spell_path

_TEXTS = ("parameters", "description", "extends", "provenance", "parts")


def print_parameters(console: Console, loaded: LoadedParameters) -> None:
    """Print the values of a set, block by block, each with its provenance, and what that means for verdicts."""
    parameters = loaded.parameters
    extends = f", extends {parameters.extends}" if parameters.extends else ""
    print_source(console, parameters.parameters, parameters.description, f"{loaded.root.mark.file}{extends}")
    content = parameters.model_dump(mode="json", exclude=set(_TEXTS))
    for name, block in content.items():
        console.print()
        print_table(console, _block(name, block, loaded))
    for index, part in enumerate(parameters.parts):
        values = ", ".join(f"{key} {_show(value)}" for key, value in part if key != "match" and value is not None)
        print_line(console, (f"\nparts[{index}]", "bold"), f"  {', '.join(part.match)}: {values}")
    kinetics = "calibrated: verdicts on residue have grade B"
    if not parameters.calibrated:
        kinetics = (
            "UNCALIBRATED: verdicts on residue have grade C, good for ranking only; see `washboard calibrate gap`"
        )
    print_line(console, ("\nkinetics", "bold"), f"  {kinetics}")
    print_line(console, ("sha256", "bold"), f"    {parameters_sha256(parameters)[:16]}")


def _block(name: str, block: dict[str, Any], loaded: LoadedParameters) -> Table:
    here = loaded.root.mark.file
    rows: list[tuple[str, ...]] = []
    for path in value_paths(block):
        value: Any = block
        for key in path:
            value = value[key]
        if value is None:
            continue
        entry = loaded.parameters.known(spell_path((name, *path)))
        interval = "" if entry.interval is None else f" ({entry.interval[0]:g} to {entry.interval[1]:g})"
        mark = loaded.root.at((name, *path)).mark
        written = f"line {mark.line}" if mark.file == here else f"{Path(mark.file).stem}:{mark.line}"
        rows.append((spell_path(path), _show(value) + interval, entry.known, entry.source, written))
    columns = (Column(name, emphasis="strong"), ">", "known", "from", Column("written in", emphasis="quiet"))
    return Table.of(columns, rows)


def _show(value: Any) -> str:
    if isinstance(value, list | tuple):
        return " to ".join(map(_show, value))
    return f"{value:g}" if isinstance(value, float) else str(value)
