"""The library's cells as cases of tests: some quick, the rest with the slow ones."""

import pytest

from robotcell.cell.load import cell_library

QUICK = ("ur5e-bench", "kr6-bench", "gantry", "cairo-bench", "lrmate-bench")
"""An arm of each closed form and make of bodies, a gantry, and a controller with a coupling."""
CELLS = [pytest.param(name, marks=() if name in QUICK else pytest.mark.slow) for name in cell_library()]
