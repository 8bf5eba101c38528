"""A silhouette: a picture of a part against its ground, as an outline in millimetres."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import contourpy
import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import ndimage
from shapely import LineString, MultiLineString, Polygon

from boards.child import ChildError, Limits, in_child
from boards.errors import BoardError
from boards.part.lines_and_arcs import fit_outline
from boards.part.picture_child import decode_grey
from geometry.arrays import Indices
from geometry.polygons import polygons_of, simplify_within
from specs.input_file import InputFile

MAX_BYTES = 100_000_000
_LIMITS = Limits(cpu_s=15, memory_bytes=1_000_000_000, wall_s=150.0)
"""The largest pictures take a second, and hardly more than half of this memory."""
_DTYPES = {"L": "u1", "I": "=i4", "F": "=f4", "I;16": "<u2", "I;16L": "<u2", "I;16B": ">u2"}
"""Of Pillow's modes."""
_LEAST_PX = 8
"""Of a part across its picture: fewer are no outline."""
_LEAST_CONTRAST = 0.1
_SPECK = 0.01
"""Of the part's area: smaller spots and holes are dirt on the lens."""
_MOST_SPECKS = 500
_HALF = 0.5
_BESIDE_PX, _FITTED_PIXELS, _ROUNDS = 3, 20_000, 4
"""Pixels around the part that do not count as ground; pixels that the ground is fitted to; how often."""
_SHADOWED, _EVEN, _LEAST_SHADOW = (0.12, 0.88), 0.12, 0.005
"""Greys of a shadow, from the part's to the ground's; how even it is; its area, as a share of the part's."""
_SIMPLIFIED_PX = 0.25
_FITTED_PX = 0.75
"""Within which lines and arcs follow an outline, a rounded corner counted."""
_STEPPED_GREY = (0.1, 0.9)
"""Of the range of greys: a picture with fewer such pixels than a tenth of its outline's is in black and white."""
_MEAN_PX, _STEP_PX, _STEPS_SIMPLIFIED_PX = 4.0, 0.45, 0.4
"""Outlines in steps become means along so many pixels, where these are no farther from the steps: corners stay."""
_SAMPLE_PX, _STRAIGHT_PX, _LEAST_MOVED = 0.25, 30.0, 0.1


@dataclass(frozen=True, slots=True, eq=False)
class Silhouette:
    """What a picture shows of a part. Picture's right and up, mm; the middle of its width is 0, its foot is 0."""

    name: str
    mm_per_pixel: float
    contour: Polygon
    """As it is seen, between the pixels."""
    outline: Polygon
    """The same as lines and arcs, whose corners the picture rounds; where these do not fit, with fewer corners, within
    a quarter of a pixel. Of a picture in black and white without its steps, within 0.9 of a pixel."""
    specks: int
    """Spots and holes that were left out."""
    threshold: float = 0.5
    """Grey of the outline, from the darker of part and ground to the brighter."""
    shadow: float = 0.0
    """Area of what was taken for a shadow, as a share of the part's."""

    @property
    def size_mm(self) -> tuple[float, float]:
        """Width and height."""
        left, foot, right, top = self.contour.bounds
        return right - left, top - foot

    @property
    def convex(self) -> bool:
        """Whether it has no hole and no bay deeper than a pixel."""
        hull = shapely.convex_hull(self.contour)
        return bool(shapely.difference(hull, self.contour.buffer(self.mm_per_pixel)).area <= 0.0)


def read_silhouette(path: Path, mm_per_pixel: float, threshold: float | None = None) -> Silhouette:
    """Find the outline of a part in its picture: darker or brighter than what surrounds it.

    Args:
        path: PNG or PGM; of a picture with transparency what is opaque is the part.
        mm_per_pixel: Scale at the part, finite and above 0.
        threshold: Grey of the outline, from the darker of part and ground to the brighter, 0 to 1; left out, half way,
            or half way from a dark part to the shadow that it casts.

    Raises:
        BoardError: it is no such picture, too large, without contrast, or shows no part, several, or one that its edge
            cuts.
    """
    if not (np.isfinite(mm_per_pixel) and 1e-6 <= mm_per_pixel <= 1e3):
        raise BoardError(f"{mm_per_pixel:g} mm per pixel is no scale; give 0.000001 to 1000")
    if threshold is not None and not 0.0 < threshold < 1.0:
        raise BoardError(f"the threshold {threshold:g} is not between 0 and 1, from the darkest to the brightest grey")
    try:
        parted = _above_ground(_grey(path), threshold)
        above = _without_specks(parted.above)
        contour = _contour(above[0])
        smooth, within = contour, _SIMPLIFIED_PX
        low, high = (float(each) for each in (above[0].min(), above[0].max()))
        grey_low, grey_high = (low + share * (high - low) for share in _STEPPED_GREY)
        greys = float(((above[0] > grey_low) & (above[0] < grey_high)).sum())
        # With hardly any greys between part and ground the outline goes along pixels.
        if greys < 0.1 * contour.length and (found := _without_steps(contour)) is not None:
            smooth, within = found, _STEPS_SIMPLIFIED_PX
        fitted = fit_outline(smooth, _FITTED_PX)
    except BoardError as error:
        raise error if error.file is not None else BoardError(str(error), file=path) from None
    left, foot, right, _ = contour.bounds
    shape, shown = (
        shapely.transform(each, lambda at: (at - [(left + right) / 2, foot]) * mm_per_pixel)
        for each in (contour, fitted)
    )
    if fitted is smooth:
        shown = simplify_within(shown, within * mm_per_pixel)
    return Silhouette(path.stem, mm_per_pixel, shape, shown, above[1], parted.threshold, parted.shadow)


def _grey(path: Path) -> NDArray[np.float32]:
    """(rows, columns) grey values of a picture, as large as they are."""
    data = InputFile(path, BoardError, "picture", MAX_BYTES).read()
    try:
        found, _ = in_child(decode_grey, data, _LIMITS)
    except ChildError as reason:
        raise BoardError(f"cannot be decoded: {reason}") from None
    head, _, pixels = found.partition(b"\n")
    mode, width, height = head.decode().split()
    values = np.frombuffer(pixels, dtype=_DTYPES[mode]).reshape(int(height), int(width)).astype(np.float32)
    if not np.isfinite(values).all():
        raise BoardError("has grey values that are no numbers")
    return values


@dataclass(frozen=True, slots=True, eq=False)
class _Parted:
    """A picture as part and ground."""

    above: NDArray[np.float32]
    """(rows, columns) above 0 on the part, below 0 on what surrounds it."""
    threshold: float
    shadow: float
    """Area of a shadow, as a share of the part's."""


def _above_ground(grey: NDArray[np.float32], threshold: float | None) -> _Parted:
    """Part a picture at a threshold, wherever its ground is brighter or darker."""
    if min(grey.shape) < _LEAST_PX:
        raise BoardError(f"{grey.shape[1]} x {grey.shape[0]} pixels are too few for an outline")
    low, high = float(grey.min()), float(grey.max())
    if high - low < _LEAST_CONTRAST * max(abs(high), abs(low), 1.0):
        raise BoardError("part and ground have almost the same grey; light the ground or the part")
    stated = _HALF if threshold is None else threshold
    level = low + stated * (high - low)
    rim = np.concatenate([grey[0], grey[-1], grey[:, 0], grey[:, -1]])
    is_dark = bool(np.median(rim) > level)
    above = level - grey if is_dark else grey - level
    shadow = 0.0
    if (above > 0.0).any():
        share = _share_of_part(grey, above > 0.0)
        bright = 1.0 - share if is_dark else share
        if threshold is None and is_dark:
            stated, shadow = _below_shadow(bright)
        above = (stated - bright if is_dark else bright - stated) * np.float32(high - low)
    above[above == 0.0] = -1e-3  # a pixel on the threshold is ground
    if max(above[0].max(), above[-1].max(), above[:, 0].max(), above[:, -1].max()) > 0.0:
        raise BoardError("the part reaches the edge of the picture; show all of it, with some ground around it")
    return _Parted(above, stated, shadow)


def _share_of_part(grey: NDArray[np.float32], is_part: NDArray[np.bool_]) -> NDArray[np.float32]:
    """(rows, columns) 0 at the grey of the ground around, 1 at that of the part: the light may differ by place.

    The ground's grey is a surface of second order through its pixels, without those that are far from it.
    """
    rows, columns = grey.shape
    y, x = np.mgrid[-1.0 : 1.0 : rows * 1j, -1.0 : 1.0 : columns * 1j]
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y])
    free = ~ndimage.binary_dilation(is_part, iterations=_BESIDE_PX)
    if free.sum() < _LEAST_PX**2:
        free = ~is_part
    some = np.flatnonzero(free)[:: max(int(free.sum()) // _FITTED_PIXELS, 1)]
    of_some, values = terms.reshape(len(terms), -1)[:, some], grey.ravel()[some].astype(np.float64)
    kept = np.ones(len(some), dtype=np.bool_)
    factors = np.zeros(len(terms))
    for _ in range(_ROUNDS):
        factors = np.linalg.lstsq(of_some[:, kept].T, values[kept], rcond=None)[0]
        off = values - factors @ of_some
        spread = 1.4826 * float(np.median(np.abs(off[kept] - np.median(off[kept]))))
        kept = np.abs(off - np.median(off[kept])) <= max(3.0 * spread, 1e-6 + 0.01 * float(np.ptp(grey)))
    ground = np.tensordot(factors, terms, axes=1)
    own = float(np.median(grey[is_part]))
    contrast = own - ground
    least = _LEAST_CONTRAST * abs(own - float(np.median(ground)))
    contrast = np.where(np.abs(contrast) < least, np.copysign(least, own - np.median(ground)), contrast)
    return ((grey - ground) / contrast).astype(np.float32)


def _below_shadow(bright: NDArray[np.float32]) -> tuple[float, float]:
    """Give the threshold for a dark part, half way to the darkest even grey beside it, and the area of such greys.

    A shadow is neither as dark as the part nor as bright as the ground over many pixels; an edge is so for one or two.
    """
    smooth = ndimage.uniform_filter(bright, 3)
    even = ndimage.maximum_filter(smooth, 5) - ndimage.minimum_filter(smooth, 5) < _EVEN
    own = int(np.sum(bright < _HALF))
    between = even & (smooth > _SHADOWED[0]) & (smooth < _SHADOWED[1])
    if between.sum() < _LEAST_SHADOW * own:
        return _HALF, 0.0
    darkest = float(np.quantile(smooth[between], 0.02))
    if darkest > 2.0 * _HALF - _EVEN:
        return _HALF, 0.0
    threshold = round(max(_HALF * darkest, _SHADOWED[0] / 2), 3)
    taken = np.sum((bright >= threshold) & (smooth < _SHADOWED[1]))
    return threshold, float(taken / max(np.sum(bright < threshold), 1))


def _without_specks(above: NDArray[np.float32]) -> tuple[NDArray[np.float32], int]:
    """Turn small spots and holes over, and count them; what is left is one piece."""
    labels, count = cast("tuple[Indices, int]", ndimage.label(above > 0.0, structure=np.ones((3, 3))))
    areas = np.bincount(labels.ravel(), minlength=count + 1)
    areas[0] = 0
    if areas.max() < _LEAST_PX**2:
        raise BoardError("shows no part: nothing of it is as large as 8 x 8 pixels; change the threshold")
    small = areas < _SPECK * areas.max()
    pieces = count - int(small[1:].sum())
    if pieces > 1:
        raise BoardError(f"shows {pieces} separate pieces; a silhouette is of one part")
    above = np.where(small[labels] & (labels > 0), -np.abs(above), above)
    ground, holes = cast("tuple[Indices, int]", ndimage.label(above < 0.0))
    sizes = np.bincount(ground.ravel(), minlength=holes + 1)
    tiny = sizes < _SPECK * areas.max()
    tiny[[0, ground[0, 0]]] = False
    specks = int(small[1:].sum()) + int(tiny.sum())
    if specks > _MOST_SPECKS:
        raise BoardError(f"shows {specks} spots and holes and no clear outline; change the threshold or the light")
    return np.where(tiny[ground], np.abs(above), above).astype(np.float32), specks


def _contour(above: NDArray[np.float32]) -> Polygon:
    """Its outline with holes, in pixels: to the right and up."""
    lines = contourpy.contour_generator(z=above).lines(0.0)
    rings = [np.asarray(line, dtype=np.float64) * [1.0, -1.0] for line in lines]
    area = shapely.build_area(MultiLineString([LineString(ring) for ring in rings if len(ring) > 3]))
    pieces = [each for each in polygons_of(area) if not each.is_empty]
    if not pieces:
        raise BoardError("shows no part: no outline closes; change the threshold")
    return max(pieces, key=lambda each: each.area)


def _without_steps(contour: Polygon) -> Polygon | None:
    """Replace an outline in steps by its mean along a few pixels; corners, which that would move farther, stay.

    So do edges that are straight for so long that they are no steps; ``None`` where hardly anything else is there.
    """
    moved: list[float] = []

    def smoothed(ring: Any) -> NDArray[np.float64]:
        corners = np.asarray(ring.coords, dtype=np.float64)
        way = np.append(0.0, np.cumsum(np.hypot(*np.diff(corners, axis=0).T)))
        at = np.linspace(0.0, way[-1], max(int(way[-1] / _SAMPLE_PX), 16), endpoint=False)
        points = np.column_stack([np.interp(at, way, corners[:, axis]) for axis in (0, 1)])
        mean = ndimage.uniform_filter1d(points, round(_MEAN_PX / _SAMPLE_PX) + 1, axis=0, mode="wrap")
        far = np.linalg.norm(mean - points, axis=1) > _STEP_PX
        straight = np.diff(way)[np.searchsorted(way, at, side="right") - 1] > _STRAIGHT_PX
        moved.append(float(np.mean(~(far | straight))))
        return np.where((far | straight)[:, None], points, mean)

    steps = simplify_within(contour, 1e-6)  # a step has one edge, however many pixels it goes along
    smooth = Polygon(smoothed(steps.exterior), [smoothed(each) for each in steps.interiors])
    return smooth if smooth.is_valid and max(moved) > _LEAST_MOVED else None
