"""Stages of a few poses, and the liquids they spray, for tests of what jets do."""

import math
from dataclasses import replace

import numpy as np
import shapely
from rigid import moved_bodies
from small_boards import THICKNESS_MM, board_of

from boards.board import Body
from boards.formats.prism import prism
from cleaning.jet.jet import jet_of
from cleaning.parameters.load import load_parameters
from cleaning.process.stages import Samples, Stage
from recipes.nozzles import AirKnife, FlatFan, FullCone, HollowCone, Radial, Wavefront
from specs.source import Source

PARAMETERS = load_parameters()
RING = HollowCone(half_angle_deg=30, ring_sigma_deg=4, flow_lpm=2.0, at_bar=3.5)
CONE = FullCone(half_angle_deg=25, flow_lpm=2.0, at_bar=3.5)
FAN = FlatFan(half_angle_deg=40, flow_lpm=2.0, at_bar=3.5)
KNIFE = AirKnife(width_mm=80, flow_lpm=400, at_bar=4.0)
LOPSIDED = HollowCone(
    half_angle_deg=30,
    flow_lpm=2.0,
    at_bar=3.5,
    wavefront=Wavefront(height_mm=50, points=[(0, 20, 26), (70, 26, 34), (160, 22, 31), (260, 30, 36)]),
)
GUN = Radial(radius_mm=40, at_mm=100, flow_lpm=math.pi * 40**4 / 16 * 60e-9, at_bar=3.5)
"""The gun of Jiangsu 2010: (R² - r²) / 8 um/s on a plate; the paper states no distance."""
NOZZLES = {"ring": RING, "lopsided": LOPSIDED, "cone": CONE, "fan": FAN, "knife": KNIFE, "radial": GUN}
SOLUTIONS = {"wash": "saponifier-15", "rinse": "di-water", "dry": "hot-air"}


def downward(tilt_deg=0.0, turn_deg=0.0):
    """(3, 3) rotation of T_board_tool: the jet points down and leans by ``tilt_deg`` towards ``turn_deg``."""
    tilt, turn = np.radians([tilt_deg, turn_deg])
    jet = np.array([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), -np.cos(tilt)])
    reference = np.array([np.cos(tilt) * np.cos(turn), np.cos(tilt) * np.sin(turn), np.sin(tilt)])
    return np.column_stack([reference, np.cross(jet, reference), jet])


def samples_of(tcp, axes=None, seconds=0.1, made_by=None, makers=("sequence[0]/sweep",)):
    """Poses one after the other; pointing straight down unless ``axes`` says otherwise."""
    tcp = np.asarray(tcp, dtype=float).reshape(-1, 3)
    axes = downward() if axes is None else np.asarray(axes)
    lasting = np.broadcast_to(np.asarray(seconds, dtype=float), len(tcp)).copy()
    return Samples(
        times=np.cumsum(lasting) - lasting / 2,
        seconds=lasting,
        tcp=tcp,
        axes=np.broadcast_to(axes, (len(tcp), 3, 3)).copy(),
        made_by=np.zeros(len(tcp), dtype=np.int64) if made_by is None else np.asarray(made_by),
        makers=tuple(map(Source.parse, makers)),
    )


def stage_of(samples, nozzle=RING, use="wash", pressure_bar=3.5):
    """A stage that sprays from these poses."""
    solution = SOLUTIONS[use]
    end = float(samples.times[-1] + samples.seconds[-1] / 2) if len(samples.times) else 0.0
    return Stage(
        made_by=Source.parse("sequence[0]"),
        function={"wash": "clean"}.get(use, use),
        use=use,
        nozzle_name="nozzle",
        nozzle=nozzle,
        solution=solution,
        liquid=PARAMETERS.liquids[solution],
        pressure_pa=pressure_bar * 1e5,
        temperature_c=60.0,
        begin_s=0.0,
        end_s=end,
        samples=samples,
    )


def sprayed(stage):
    """The stage's jet with the default parameters."""
    return jet_of(stage, PARAMETERS.spray)


def one_jet(nozzle=RING, use="wash", pressure_bar=3.5):
    """The jet of a nozzle."""
    return sprayed(stage_of(samples_of([[0.0, 0.0, 50.0]]), nozzle, use, pressure_bar))


def solid_board(*parts, **known):
    """``board_of`` these parts, with a box for each that stands ``gap_height_mm`` above its side's surface."""
    board = board_of(*parts, **known)
    bodies = []
    for each in parts:
        gap, top = each.gap_height_mm, each.height_mm
        low, high = (gap, top) if each.side == "top" else (-THICKNESS_MM - top, -THICKNESS_MM - gap)
        patches, normals, surfaces = prism(each.outline, low, high)
        bodies.append(Body(each.name, "component", patches, normals, surfaces, side=each.side))
    return replace(board, bodies=(*board.bodies, *bodies))


def moved_board(board, motion):
    """A board moved by a ``rigid.Motion``, as far as rays see it."""
    turn = motion.matrix[:2, :2]
    sideways = np.array(motion.shift[:2])

    def move(outline):
        return shapely.transform(outline, lambda points: points @ turn.T + sideways)

    components = [
        replace(each, footprint=move(each.footprint), outline=move(each.outline)) for each in board.components
    ]
    return replace(
        board,
        bodies=moved_bodies(board.bodies, motion),
        outline=move(board.outline),
        axis=tuple((turn @ board.axis).tolist()),
        top_z_mm=board.top_z_mm + motion.shift[2],
        bottom_z_mm=board.bottom_z_mm + motion.shift[2],
        components=tuple(components),
    )


def moved_samples(samples, motion):
    """Poses moved by a ``rigid.Motion``."""
    return replace(samples, tcp=motion.points(samples.tcp), axes=motion.matrix @ samples.axes)
