"""The bodies of an order: its board, joined with the 3-D models and the tables that come with it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.spatial import KDTree

from boards.board import NOMINAL_HEIGHT, STATED_HEIGHT, Board, Body, Instance, Side, SourceFile
from boards.bounds import check_bodies
from boards.errors import BoardError
from boards.formats.names import listed, some
from boards.panel import moved_bodies
from boards.parts_table.columns import COLUMNS_FILE
from boards.parts_table.fit import NEAR_MM, Fit, fit_pairs, fit_points
from boards.parts_table.join import Slab, assign, centre, fill_row, join_parts, not_mounted, slab_of, state_heights
from boards.parts_table.order import Order, Rival
from boards.parts_table.read import Row
from boards.parts_table.tables import HEIGHT_MM, Statements
from boards.sub_boards import take_apart
from boards.understand import understand
from geometry.arrays import Points2
from specs.finding import Finding
from specs.finding_rules import (
    MODEL_FOUND,
    MODEL_OBSTACLES,
    MODEL_WITHOUT_BODY,
    ORDER_BOARDS,
    PARTS_BY_POSITION,
    PARTS_FRAME,
    PARTS_NOT_FITTED,
)
from specs.progress import Progress, subprogress

_SIZE_MM = 0.5
"""Outlines of one board may differ by this."""
_THICKNESS_MM = 0.2
"""Thicknesses, too: models leave copper and mask out."""
_HEIGHT = 0.1
"""Part of a height by which a model may differ from the statement on it."""
_FEWEST = 3
"""Designators that find out how a model lies on a board; fewer leave its turn open."""


def read_order(order: Order, progress: Progress) -> tuple[Order, tuple[Body, ...], tuple[Finding, ...]]:
    """Read the board of an order, with the bodies of its 3-D model, and join the tables.

    Gerber files that cannot be read, or place no component, are not the board where another file is.

    Raises:
        BoardError: The board cannot be read.
    """
    whole = replace(order.given, others=[*order.given.others], contradictions=[], units={})
    form = order.form
    takes = {"given": order.given, "progress": subprogress(progress, 0.0, 0.6)}
    try:
        bodies, findings = form.function("read")(order.board, **{key: takes[key] for key in form.takes})
        reason = "" if any(body.role == "component" for body in bodies) else f"{form.name} without components"
    except BoardError as error:
        if "given" not in form.takes or not order.rivals:
            raise
        bodies, findings, reason = (), (), str(error)
    if "given" in form.takes and reason and order.rivals:
        first, *rest = order.rivals
        whole.others.append(SourceFile(order.label, "not read", reason))
        other = replace(order, board=first.file, form=first.form, label=first.label, given=whole, rivals=tuple(rest))
        return read_order(other, progress)
    bodies, more = _join_models(order, bodies, progress)
    findings = (*findings, *order.findings, *more)
    given = order.given
    if "given" not in form.takes and (given.tables or given.netlists):
        check_bodies(bodies)
        progress(f"joining {', '.join(table.file.name for table in given.tables)}", 0.95)
        bodies, more = join_parts(bodies, given)
        findings = (*findings, *more)
    if given.heights_mm:
        bodies, more = state_heights(bodies, given)
        findings = (*findings, *more)
    return order, bodies, findings


def _join_models(order: Order, bodies: tuple[Body, ...], progress: Progress) -> tuple[tuple[Body, ...], list[Finding]]:
    """Join the first 3-D model that is of the board; the error finding where none is and nothing states the board."""
    notes: list[Finding] = []
    others: list[_Match] = []
    panel = _Panel(order, bodies)
    rows = (row for table in order.given.tables for row in table.rows if "given" in order.form.takes)
    noted = frozenset(row.ref.casefold() for row in rows if not row.is_fitted)
    is_joined = False
    for rival in order.rivals:
        if order.form.name in _MODELS or rival.form.name not in _MODELS or is_joined:
            words = f"{rival.form.name}; {order.label} is the board"
            order.given.others.append(SourceFile(rival.label, "not read", words))
            continue
        progress(f"reading {rival.label}", 0.6)
        try:
            drawn, read = rival.form.function("read")(rival.file, progress=subprogress(progress, 0.6, 0.9))
            check_bodies(drawn)
        except BoardError as error:
            words = f"{rival.form.name} that cannot be read: {error}"
            order.given.others.append(SourceFile(rival.label, "not read", words))
            continue
        match = _Match(order.label, rival, bodies, drawn, noted)
        if match.fit is not None and match.is_one_size(match.fit):
            is_joined = True
            bodies, found = match.join(match.fit, order.given)
            notes += [*read, *found]
        elif found := panel.join(match):
            is_joined = panel.is_full
            bodies = panel.bodies
            notes += [*read, *found]
        elif match.fit is not None:
            is_joined = True
            bodies, found = match.join(match.fit, order.given)
            notes += [*read, *found]
        else:
            others.append(match)
    for match in others:
        order.given.others.append(SourceFile(match.rival.label, "not read", f"not of one board with {order.label}"))
    if others and not is_joined and not panel.joined and order.stated.model.board is None:
        notes.append(Finding(ORDER_BOARDS, max(others, key=lambda each: len(each.pairs)).refusal()))
    return bodies, notes


@dataclass(eq=False)
class _Panel:
    """The boards of a panel, which get the bodies of models of single boards."""

    order: Order
    bodies: tuple[Body, ...]
    """Of the whole panel."""
    joined: set[int] = field(default_factory=set[int])
    """Numbers of the instances that have theirs."""

    @cached_property
    def instances(self) -> tuple[Instance, ...]:
        """Boards of the panel; none where it is one board, or no board."""
        if self.order.stated.model.panel == "whole" or sum(body.role == "component" for body in self.bodies) < 2:
            return ()
        try:
            return take_apart(understand(self.bodies, "panel"), (), self.order.stated.model.panel).instances
        except BoardError:  # that is noted where the board is understood
            return ()

    @property
    def is_full(self) -> bool:
        """Whether every board has its bodies."""
        return len(self.joined) == len(self.instances)

    def join(self, model: "_Match") -> list[Finding]:
        """Give the boards that a model is of its bodies; what was noticed, nothing where it is of none."""
        notes: list[Finding] = []
        dressed: dict[int, Board | None] = {}
        fitting: list[str] = []
        for number, instance in enumerate(self.instances):
            if number in self.joined:
                continue
            key = id(instance.board)
            if key not in dressed:
                match = replace(model, bodies=instance.board.bodies)
                fit = match.fit if match.fit is not None and match.is_one_size(match.fit) else None
                is_first = not any(each is not None for each in dressed.values())
                given = self.order.given if is_first else replace(self.order.given, others=[], contradictions=[])
                bodies, found = match.join(fit, given) if fit is not None else ((), [])
                notes += found if is_first else []
                dressed[key] = understand(bodies, instance.board.name) if bodies else None
            if (board := dressed[key]) is not None:
                self._dress(instance, board)
                self.joined.add(number)
                fitting.append(instance.name)
        if not fitting:
            return []
        text = (
            f"{model.rival.label} is a model of one board of the panel {model.label}: {len(fitting)} of "
            f"{len(self.instances)} boards have its bodies, namely {some(fitting)}."
        )
        return [Finding(MODEL_FOUND, text), *(each for each in notes if each.rule is not MODEL_FOUND)]

    @cached_property
    def _spots(self) -> dict[Side, tuple[list[int], KDTree]]:
        """Components of each side by number, and their centres."""
        slab = slab_of(self.bodies)
        found: dict[Side, tuple[list[int], KDTree]] = {}
        for side in ("top", "bottom"):
            numbers = [number for number, body in enumerate(self.bodies) if body.role == "component" and
                       (body.side or slab.side_of(body)) == side]  # fmt: skip
            if numbers:
                found[side] = numbers, KDTree([centre(self.bodies[number]) for number in numbers])
        return found

    def _dress(self, instance: Instance, board: Board) -> None:
        """Give the panel's bodies at the places of an instance those of its board with a model."""
        spots, slab = self._spots, slab_of(self.bodies)
        result, names = list(self.bodies), {body.name for body in self.bodies}
        stood = {body.name: body for body in moved_bodies(instance)}
        for body in moved_bodies(replace(instance, board=board)):
            own = stood.get(body.name)
            if own is not None and own.role == "component":
                numbers, tree = spots[own.side or slab.side_of(own)]
                number = numbers[int(np.asarray(tree.query(centre(own))[1]).item())]
                taken = {key: getattr(body, key) for key in ("patches", "normals", "surfaces", "package", "extra")}
                result[number] = replace(result[number], **taken)
                continue
            name = body.name
            while name in names:
                name += "-model"
            names.add(name)
            result.append(replace(body, name=name, role="fixture", side=None))
        self.bodies = tuple(result)


_MODELS = ("STEP", "glTF")


@dataclass(frozen=True, eq=False)
class _Match:
    """A board and a 3-D model beside it."""

    label: str
    """Of the board."""
    rival: Rival
    bodies: Sequence[Body]
    """Of the board."""
    drawn: Sequence[Body]
    """Of the model, in its own frame."""
    noted: frozenset[str] = frozenset()
    """Components in small letters that were noted as not fitted."""

    @cached_property
    def parts(self) -> dict[str, Body]:
        """Components of the board by name in small letters."""
        return _components(self.bodies)

    @cached_property
    def models(self) -> dict[str, Body]:
        """Those of the model."""
        return _components(self.drawn)

    @cached_property
    def pairs(self) -> dict[str, tuple[Body, Body]]:
        """Component of the board and body of the model, by the name that both have."""
        return {name: (self.parts[name], body) for name, body in self.models.items() if name in self.parts}

    @cached_property
    def fit(self) -> Fit | None:
        """Map from the model's plan onto the board's; ``None`` where they cannot be of one board."""
        parts, models = list(self.parts.values()), list(self.models.values())
        if 2 * len(self.pairs) >= min(len(parts), len(models)) and self.pairs:
            places = [(centre(model), centre(part)) for part, model in self.pairs.values()]
            fit = fit_pairs(*np.array(places).transpose(1, 0, 2))
            if fit.error_mm > NEAR_MM or (len(self.pairs) < _FEWEST and not self.is_one_size(fit)):
                return None
        elif parts and models and not self.pairs and self.is_one_size():
            fit = fit_points(np.array(list(map(centre, models))), np.array(list(map(centre, parts))))
            if fit is None:
                return None
        else:
            return None
        # Parts reach over their places, and outlines are exact.
        if not self.is_one_size(fit):
            return fit
        return replace(fit, shift_mm=fit.shift_mm + _box(self.bodies)[0] - self._model_box(fit)[0])

    def _model_box(self, fit: Fit | None = None) -> Points2:
        corners = _box(self.drawn) if fit is None else fit.apply(_box(self.drawn))
        return np.array([corners.min(axis=0), corners.max(axis=0)])

    def is_one_size(self, fit: Fit | None = None) -> bool:
        """Whether both outlines are as large, turned in any way without a fit."""
        sizes = np.ptp(_box(self.bodies), axis=0), np.ptp(self._model_box(fit), axis=0)
        apart = np.abs(sizes[0] - sizes[1]).max()
        return bool(apart <= _SIZE_MM or (fit is None and np.abs(sizes[0] - sizes[1][::-1]).max() <= _SIZE_MM))

    def refusal(self) -> str:
        """Both readings, why they are not of one board, and what to state."""
        known = len(self.pairs), min(len(self.parts), len(self.models))
        reason = f"{known[0]} of {known[1]} designators are in both"
        if 2 * known[0] >= known[1] and known[0]:
            reason += ", and their places do not fit each other"
        file, beside = self.rival.label, f"{COLUMNS_FILE} beside the order"
        return (
            f"{self._reading(self.label, self.bodies)} and {self._reading(file, self.drawn)} cannot be of one board: "
            f"{reason}. {self.label} is taken alone; name the one that is meant in {beside}, as `board: {self.label}` "
            f"or `board: {file}`."
        )

    def _reading(self, label: str, bodies: Sequence[Body]) -> str:
        width, depth = np.ptp(_box(bodies), axis=0)
        return f"{label} ({len(_components(bodies))} components on {width:.1f} x {depth:.1f} mm)"

    def join(self, fit: Fit, given: Statements) -> tuple[tuple[Body, ...], list[Finding]]:
        """Give the board's components the bodies of the model; what contradicts is added to the statements."""
        slab, file = slab_of(self.bodies), self.rival.label
        self._compare_boards(fit, given)
        moved = [_moved(body, fit, slab_of(self.drawn), slab) for body in self.drawn if body.role != "board"]
        found = dict(self._bodies(moved))
        taken, joined = set[str](), list[Body]()
        by_place: list[str] = []
        bare: list[str] = []
        for body in self.bodies:
            model = found.get(body.name)
            joined.append(body if model is None else self._joined(body, model, slab, given))
            if model is not None:
                taken.add(model.name)
                if model.name.casefold() != body.name.casefold():
                    by_place.append(f"{body.name} = {model.name}")
            elif body.role == "component":
                bare.append(body.name)
        names = {body.name for body in self.bodies}
        stated = [row for table in given.tables for row in table.rows]
        omitted = {row.ref.casefold() for row in stated if not row.is_fitted} | not_mounted(self.bodies)
        rows = {row.ref.casefold(): row for row in stated if row.ref.casefold() not in omitted}
        around: list[str] = []
        unmounted: list[str] = []
        for body in (each for each in moved if each.name not in taken):
            if body.role == "component" and body.name.casefold() in omitted:
                unmounted += [body.name] * (body.name.casefold() not in self.noted)
                continue
            row = rows.get(body.name.casefold())
            name = body.name
            while name in names:
                name += "-model"
            names.add(name)
            if body.role == "component" and row is not None and body.name == name:
                joined.append(fill_row(body, row, slab, given))
            else:
                joined.append(replace(body, name=name, role="fixture", side=None))
                around += [name] * (body.role == "component")
        notes = [Finding(MODEL_FOUND, f"{len(taken)} of {len(self.parts)} components have the bodies of {file}, "
                                      f"joined to {self.label}.")]  # fmt: skip
        if words := fit.describe():
            notes.append(Finding(PARTS_FRAME, f"The places in {file} were {words} to fit {self.label}."))
        given.others.append(SourceFile(file, f"3-D model, {self.rival.form.name}", f"{len(taken)} bodies"))
        return tuple(joined), [
            *notes,
            *listed(PARTS_BY_POSITION, by_place, f"bodies of {file} joined by position: {{}}."),
            *listed(MODEL_WITHOUT_BODY, bare, f"components have no body in {file} and keep their own: {{}}."),
            *listed(MODEL_OBSTACLES, around, f"bodies of {file} are of no component of {self.label} and are kept as "
                                             "obstacles: {}."),
            *listed(PARTS_NOT_FITTED, unmounted, f"bodies of {file} are of components that are not fitted, and are "
                                                 "left out: {}."),
        ]  # fmt: skip

    def _bodies(self, moved: Sequence[Body]) -> Iterator[tuple[str, Body]]:
        """Name on the board with the body of the model: by designator, the others by their places."""
        models = _components(moved)
        yield from ((self.parts[name].name, models[name]) for name in self.pairs)
        for side in ("top", "bottom"):
            parts = [body for name, body in self.parts.items() if name not in self.pairs and body.side == side]
            free = [body for name, body in models.items() if name not in self.pairs and body.side == side]
            places = np.array(list(map(centre, free))).reshape(-1, 2)
            yield from ((parts[to].name, free[number]) for number, to in assign(places, parts))

    def _joined(self, body: Body, model: Body, slab: Slab, given: Statements) -> Body:
        """Take the body of the model, unless it lies on the other side or elsewhere."""
        row, file = Row(0, body.name), self.rival.label
        side = body.side or slab.side_of(body)
        if model.side is not None and model.side != side:
            given.contradict(row, "side", (side, self.label), (model.side, file))
            return body
        if not assign(centre(model)[None], [body]) and not assign(centre(body)[None], [model]):
            (x, y), (u, v) = centre(body).tolist(), centre(model).tolist()
            given.contradict(row, "place", (f"({x:z.2f}, {y:z.2f})", self.label), (f"({u:z.2f}, {v:z.2f})", file))
            return body
        is_nominal = any(key == NOMINAL_HEIGHT and source != STATED_HEIGHT for key, source in body.extra)
        stated, drawn = slab.height_of(body, side), slab.height_of(model, side)
        if not is_nominal and abs(stated - drawn) > max(HEIGHT_MM, _HEIGHT * drawn):
            given.contradict(row, "height", (f"{drawn:.2f} mm", file), (f"{stated:.2f} mm", self.label))
        extra = tuple(pair for pair in body.extra if pair[0] != NOMINAL_HEIGHT)
        package = body.package or model.package
        return replace(
            body, patches=model.patches, normals=model.normals, surfaces=model.surfaces, package=package, extra=extra
        )

    def _compare_boards(self, fit: Fit, given: Statements) -> None:
        row, file = Row(0, "board"), self.rival.label
        if not self.is_one_size(fit):
            sizes = [
                "{:.1f} x {:.1f} mm".format(*np.ptp(box, axis=0)) for box in (_box(self.bodies), self._model_box(fit))
            ]
            given.contradict(row, "size", (sizes[0], self.label), (sizes[1], file))
        one, other = slab_of(self.bodies), slab_of(self.drawn)
        if abs((one.high - one.low) - (other.high - other.low)) > _THICKNESS_MM:
            words = [f"{each.high - each.low:.2f} mm" for each in (one, other)]
            given.contradict(row, "thickness", (words[0], self.label), (words[1], file))


def _components(bodies: Sequence[Body]) -> dict[str, Body]:
    return {body.name.casefold(): body for body in bodies if body.role == "component"}


def _box(bodies: Sequence[Body]) -> Points2:
    """Least and largest corner (2, 2) of the bare board."""
    plan = next(body.patches[:, :, :2].reshape(-1, 2) for body in bodies if body.role == "board")
    return np.array([plan.min(axis=0), plan.max(axis=0)])


def _moved(body: Body, fit: Fit, own: Slab, slab: Slab) -> Body:
    """Bring a body of the model onto the surface of its side of the board; a mirrored plan is one turned over."""
    up = 1.0 if np.linalg.det(fit.linear) > 0.0 else -1.0
    side = own.side_of(body)
    surface = own.high if side == "top" else own.low
    if up < 0.0:
        side = "bottom" if side == "top" else "top"
    patches, normals = body.patches.copy(), body.normals.copy()
    patches[:, :, :2] = np.round(fit.apply(patches[:, :, :2].reshape(-1, 2)), 4).reshape(-1, 3, 2) + 0.0
    heights = np.round((patches[:, :, 2] - surface) * up, 4)
    patches[:, :, 2] = heights + (slab.high if side == "top" else slab.low)
    normals[:, :2] = normals[:, :2] @ fit.linear.T
    normals[:, 2] *= up
    return replace(body, patches=patches, normals=normals, side=side)
