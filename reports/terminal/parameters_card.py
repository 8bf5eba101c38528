"""A parameter set on the terminal: every value, how it is known, and where it was written."""

from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from cleaning.parameters.consistency import value_paths
from cleaning.parameters.load import LoadedParameters, parameters_sha256
from specs.yaml.located import spell_path

_TEXTS = ("parameters", "description", "extends", "provenance", "parts")


def print_parameters(console: Console, loaded: LoadedParameters) -> None:
    """Print the values of a set, block by block, each with its provenance, and what that means for verdicts."""
    parameters, root = loaded.parameters, loaded.root
    console.print(f"[bold]{escape(parameters.parameters)}[/bold]  {escape(parameters.description)}")
    extends = f", extends {parameters.extends}" if parameters.extends else ""
    console.print(f"{escape(root.mark.file)}{escape(extends)}", style="dim", soft_wrap=True, highlight=False)
    content = parameters.model_dump(mode="json", exclude=set(_TEXTS))
    for name, block in content.items():
        console.print()
        console.print(_block(name, block, loaded))
    for index, part in enumerate(parameters.parts):
        told = ", ".join(f"{key} {_show(value)}" for key, value in part if key != "match" and value is not None)
        console.print(f"\n[bold]parts\\[{index}][/bold]  {escape(', '.join(part.match))}: {escape(told)}")
    kinetics = "calibrated: verdicts on residue have grade B"
    if not parameters.calibrated:
        kinetics = (
            "UNCALIBRATED: verdicts on residue have grade C, good for ranking only; see `washboard calibrate gap`"
        )
    console.print(f"\n[bold]kinetics[/bold]  {kinetics}")
    console.print(f"[bold]sha256[/bold]    {parameters_sha256(parameters)[:16]}")


def _block(name: str, block: dict[str, Any], loaded: LoadedParameters) -> Table:
    table = Table(box=None, pad_edge=False, header_style="dim", padding=(0, 2, 0, 0))
    table.add_column(name, style="bold", overflow="fold")
    table.add_column("", justify="right")
    table.add_column("known", overflow="fold")
    table.add_column("from", overflow="fold")
    table.add_column("written in", style="dim", overflow="fold")
    here = loaded.root.mark.file
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
        cells = (spell_path(path), _show(value) + interval, entry.known, entry.source, written)
        table.add_row(*(escape(cell) for cell in cells))
    return table


def _show(value: Any) -> str:
    if isinstance(value, list | tuple):
        return " to ".join(map(_show, value))
    return f"{value:g}" if isinstance(value, float) else str(value)
