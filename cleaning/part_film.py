"""The film that a program lays on the faces of a part, as planned or as a controller drives it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from boards.board import Part, scene_of
from boards.part.cells import FilmCells, film_cells
from cleaning.exposure.segment_rates import cut, joined, segment_rates, sprayed_moves
from cleaning.jet.jet import form_of
from cleaning.parameters.load import load_parameters
from geometry.arrays import Points, Scalars
from programs.program import TimedProgram
from recipes.footprint import mean_angle
from recipes.paths import Film, Slices
from recipes.recipe import Recipe
from specs.source import Source

_CELLS, _JOINED, _CUT = 20.0, 10.0, 5.0
"""In the radius of the pattern: cells, lengths that moves are joined to, and lengths that they are cut to."""


@dataclass(frozen=True, slots=True, eq=False)
class LaidFilm:
    """What one template of one step lays."""

    film: Film
    cells: FilmCells
    thickness_um: Scalars
    """(n,) on the cells."""

    @property
    def is_within(self) -> NDArray[np.bool_]:
        """(n,) whether the film is within its tolerance."""
        off = np.abs(self.thickness_um - self.film.thickness_um)
        return np.asarray(off <= self.film.tolerance_um * (1.0 + 1e-9))

    def nearest(self, points: Points) -> NDArray[np.int64]:
        """(m,) cell that is nearest to each point (m, 3)."""
        return np.asarray(KDTree(self.cells.points).query(points)[1], dtype=np.int64)


@dataclass(frozen=True, slots=True)
class FilmOnFace:
    """The film on one face; mm, um."""

    thickness_um: float
    """That the recipe states."""
    tolerance_um: float
    least_um: float
    mean_um: float
    most_um: float
    deviation: float
    """Greatest |film - thickness| / thickness."""
    within_share: float
    """Of the area that can be seen, where the film is within its tolerance."""
    thin_mm2: float
    """Thinner than the tolerance allows."""
    thick_mm2: float
    """Thicker."""
    thinnest: tuple[float, float, float]
    """Where, in the part's frame."""
    thickest: tuple[float, float, float]


def film_laid(program: TimedProgram, part: Part, recipe: Recipe, place: Source) -> LaidFilm:
    """Add up what the moves of one template lay on the faces of a part.

    Args:
        program: Planned on the part, as planned or as driven.
        part: With its fixtures, which cast shadows.
        recipe: The program's.
        place: Step and template, which states a film.
    """
    spec = recipe.templates[place.template]
    assert isinstance(spec, Slices)
    assert spec.film is not None
    assert place.step is not None
    step = recipe.sequence[place.step]
    nozzle, function = recipe.nozzles[step.nozzle], recipe.functions[step.function]
    flow = nozzle.flow_lpm * float(np.sqrt(function.pressure_bar / nozzle.at_bar)) * spec.film.deposited
    radius = spec.standoff_mm * float(np.tan(mean_angle(nozzle)))
    moves = joined(*sprayed_moves(program, lambda source: source.place == place), radius / _JOINED)
    segments, seconds = cut(*moves, radius / _CUT)
    cells = film_cells(part, radius / _CELLS)
    form = form_of(nozzle, flow, load_parameters("default").spray)
    rates = segment_rates(form, segments, cells.points, cells.normals, scene_of(part))
    return LaidFilm(spec.film, cells, np.asarray(rates @ seconds, dtype=np.float64))


def film_on_face(laid: LaidFilm, own: NDArray[np.bool_]) -> FilmOnFace:
    """Give the film on some cells (n,), of which there is one at least."""
    rows = np.flatnonzero(own)
    film, areas, required = laid.thickness_um[rows], laid.cells.areas_mm2[rows], laid.film
    low, high = int(np.argmin(film)), int(np.argmax(film))
    x, y, z = laid.cells.points[rows[low]].tolist()
    u, v, w = laid.cells.points[rows[high]].tolist()
    thin, thick = (
        float(areas[side * (film - required.thickness_um) > required.tolerance_um * (1.0 + 1e-9)].sum())
        for side in (-1.0, 1.0)
    )
    return FilmOnFace(
        thickness_um=required.thickness_um,
        tolerance_um=required.tolerance_um,
        least_um=float(film[low]),
        mean_um=float((film * areas).sum() / areas.sum()),
        most_um=float(film[high]),
        deviation=float(np.abs(film / required.thickness_um - 1.0).max()),
        within_share=1.0 - (thin + thick) / float(areas.sum()),
        thin_mm2=thin,
        thick_mm2=thick,
        thinnest=(x, y, z),
        thickest=(u, v, w),
    )
