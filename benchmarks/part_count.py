"""What is held on parts, counted three times: by the plan, by the analysis, and by rays of this file's own.

    python benchmarks/part_count.py [NAME ...]

Points are spread over the sprayed faces. Every 10 ms of the timed program each is looked at: is it nearer than
the jet's range, inside its sharp cone, met no flatter than the template allows, and free of all triangles on the
straight way (each triangle is tried)? Shares are of all the area of the faces, seen or not, so that no count rests on
another's.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
from numba import njit

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "support"))

from small_parts import block, cylinder, part_of, prism
from step_writer import StepWriter

from boards.board import Part
from boards.part.load import load_part
from cleaning.part_faces import judge_faces, times_in_cone, weigh_faces
from programs.playback import build_timeline, play
from recipes.load import load_recipe
from rulesengine.planning.pipeline import run
from rulesengine.surface.part_job import survey_part

POINTS, STEP_S = 4000, 0.01
GOLDEN = np.array([0.7548776662466927, 0.5698402909980532])
"""Of the plane: 1 / 1.3247 and its square."""


def comb() -> list[tuple[float, float]]:
    """Ring of a back with six teeth: 26 sides."""
    ring = [(0.0, 0.0), (174.0, 0.0)]
    for tooth in range(6):
        right = 174.0 - 30.0 * tooth
        ring += [(right, 70.0), (right - 24.0, 70.0), (right - 24.0, 25.0), (right - 30.0, 25.0)]
    return ring[:-2]


def read_step(folder: Path) -> Part:
    """A STEP file of 26 plane faces, as CAD writes it, with its underside left alone."""
    writer = StepWriter()
    (folder / "comb.step").write_text(writer.write_solid("comb", writer.prism(comb(), 0.0, 60.0)))
    (folder / "comb.yaml").write_text(
        "part: comb\nbody: {file: comb.step}\nfaces: {ignore: [{normal: [0, 0, -1]}]}\n"
        "fixtures: {table: {kind: box, size_mm: [400, 300, 20], at: {xyz_mm: [87, 35, -10]}}}\n"
    )
    return load_part(folder / "comb.yaml")


def parts(folder: Path) -> dict[str, Part]:
    table = block((-150, -150, -20), (350, 300, 0))
    tub = prism([(0, 0), (200, 0), (200, 20), (20, 20), (20, 130), (200, 130), (200, 150), (0, 150)], 0, 120)
    steps = prism([(0, 0), (160, 0), (160, 40), (110, 40), (110, 75), (60, 75), (60, 110), (0, 110)], 0, 45)
    return {
        "f-bracket": load_part("f-bracket"),
        "comb.step": read_step(folder),
        "channel": part_of(tub, table=table),
        "steps": part_of(steps, table=table),
        "cylinder": part_of(cylinder(35, 90), table=table),
        "slab": part_of(block((0, 0, 0), (160, 110, 30)), table=table),
    }


@njit
def count(points, normals, tcp, axes, corners, rules):  # type: ignore[no-untyped-def]
    """(n,) seconds of points; rules are cosine of the half angle, sine of the incidence, range, step."""
    cosine, sine, reach, step = rules
    found = np.zeros(len(points))
    for i in range(len(points)):
        px, py, pz = points[i]
        nx, ny, nz = normals[i]
        for j in range(len(tcp)):
            x, y, z = px - tcp[j, 0], py - tcp[j, 1], pz - tcp[j, 2]
            far = np.sqrt(x * x + y * y + z * z)
            if far > reach or x * axes[j, 0] + y * axes[j, 1] + z * axes[j, 2] < cosine * far:
                continue
            if -(x * nx + y * ny + z * nz) < sine * far:
                continue
            way, free = np.array([x, y, z]), True
            for k in range(len(corners)):
                one, two = corners[k, 1] - corners[k, 0], corners[k, 2] - corners[k, 0]
                across = np.cross(way, two)
                volume = (one * across).sum()
                if abs(volume) < 1e-12:
                    continue
                begin = tcp[j] - corners[k, 0]
                u = (begin * across).sum() / volume
                other = np.cross(begin, one)
                v = (way * other).sum() / volume
                share = (two * other).sum() / volume
                if u >= 0 and v >= 0 and u + v <= 1 and 0 < share < 1 - 1e-6:
                    free = False
                    break
            if free:
                found[i] += step
    return found


def main() -> None:
    recipe = load_recipe("part-degrease")
    spec, rng = recipe.templates["all_faces"], np.random.default_rng(3)
    with tempfile.TemporaryDirectory() as folder:
        found = parts(Path(folder))
    print("| part | faces | range | plan | analyse | own rays | apart | verdict | short mm2 | spray | bound | ratio |")
    for name, part in found.items():
        if sys.argv[1:] and name not in sys.argv[1:]:
            continue
        done = run(recipe, part)
        covering = done.coverings[0]
        areas = covering.cells.areas_mm2
        planned = float(areas[covering.seconds >= spec.required_s * (1 - 1e-9)].sum() / areas.sum())
        held = times_in_cone(done.program, part, recipe)
        survey = survey_part(recipe, part)
        verdicts = judge_faces(part, held, survey.visible, survey.hider)
        whole = weigh_faces(verdicts)
        analysed = float(areas[held[0].seconds >= spec.required_s - 0.01].sum() / areas.sum())
        patches = np.concatenate([part.patches[face.patches] for face in part.served])
        crossed = np.cross(patches[:, 1] - patches[:, 0], patches[:, 2] - patches[:, 0])
        sizes = np.linalg.norm(crossed, axis=1)
        along = (np.arange(POINTS) + rng.random(POINTS)) / POINTS
        which = np.searchsorted(np.cumsum(sizes / sizes.sum()), along).clip(0, len(sizes) - 1)
        u, v = (np.arange(POINTS)[:, None] * GOLDEN % 1.0).T  # spread evenly in each triangle
        u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
        mine = patches[which]
        points = mine[:, 0] + u[:, None] * (mine[:, 1] - mine[:, 0]) + v[:, None] * (mine[:, 2] - mine[:, 0])
        times = np.arange(0.0, done.program.totals.duration_s, STEP_S) + STEP_S / 2
        states = play(build_timeline(done.program), times)
        on = states.spraying
        rules = (np.cos(np.radians(15)), np.sin(np.radians(spec.incidence_min_deg)), covering.range_mm, STEP_S)
        seconds = count(
            points, (crossed / sizes[:, None])[which], states.tcp[on], states.approach[on],
            np.concatenate([body.patches for body in part.bodies]), rules,
        )  # fmt: skip
        own = float((seconds >= spec.required_s - 0.01).mean())
        apart = 100 * (max(planned, analysed, own) - min(planned, analysed, own))
        least = covering.least().seconds
        print(
            f"| {name} | {len(part.served)} | {covering.range_mm:.0f} | {planned:.2%} | {analysed:.2%} | {own:.2%} | "
            f"{apart:.2f} | {whole.verdict} | {whole.short_mm2:.0f} | {covering.spray_s:.1f} | {least:.1f} | "
            f"{covering.spray_s / least:.3f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
