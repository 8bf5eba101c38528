"""Program robots that spray-clean circuit boards, from Python.

Boards, panels and parts are opened, recipes opened and edited, then planned, analysed, checked in a robot cell, tuned
and studied; what comes of it can be looked at, and shows itself in a notebook::

    import washboard as wb

    plan = wb.plan(wb.open_workpiece("board.step"), wb.open_recipe("smt-aqueous"), cell="ur5e-bench")
    clean = wb.analyse(plan)
    wb.check(plan, "ur5e-bench").export("out/")

Whatever cannot be done raises a ``JobError`` that states where and what to do. The packages that do the work are
imported when they are needed.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from specs.errors import JobError as JobError
    from washboard.checked import Checked as Checked
    from washboard.checked import check as check
    from washboard.cleaned import Cleaned as Cleaned
    from washboard.cleaned import analyse as analyse
    from washboard.driven import DrivenVerdict as DrivenVerdict
    from washboard.driven import judge_driven as judge_driven
    from washboard.inputs import OpenedProgram as OpenedProgram
    from washboard.inputs import OpenedRecipe as OpenedRecipe
    from washboard.inputs import open_board as open_board
    from washboard.inputs import open_cell as open_cell
    from washboard.inputs import open_program as open_program
    from washboard.inputs import open_recipe as open_recipe
    from washboard.inputs import open_workpiece as open_workpiece
    from washboard.planned import Planned as Planned
    from washboard.planned import plan as plan
    from washboard.studied import Studied as Studied
    from washboard.studied import study as study
    from washboard.tuned import Tuned as Tuned
    from washboard.tuned import tune as tune
    from washboard.validated import Validated as Validated
    from washboard.validated import validate as validate

DISTRIBUTION = "washboard"

_PLACES = {
    "specs.errors": ("JobError",),
    "washboard.checked": ("Checked", "check"),
    "washboard.cleaned": ("Cleaned", "analyse"),
    "washboard.driven": ("DrivenVerdict", "judge_driven"),
    "washboard.inputs": (
        "OpenedProgram", "OpenedRecipe", "open_board", "open_cell", "open_program", "open_recipe", "open_workpiece",
    ),
    "washboard.planned": ("Planned", "plan"),
    "washboard.studied": ("Studied", "study"),
    "washboard.tuned": ("Tuned", "tune"),
    "washboard.validated": ("Validated", "validate"),
}  # fmt: skip
_MODULES = {name: module for module, names in _PLACES.items() for name in names}
__all__ = sorted(_MODULES)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    """Import a name when it is used."""
    if name not in _MODULES:
        raise AttributeError(f"module 'washboard' has no attribute {name!r}; it has {', '.join(__all__)}")
    return getattr(import_module(_MODULES[name]), name)


def __dir__() -> list[str]:
    return __all__
