"""Verdicts of an earlier revision and of now, component by component: which rules changed which verdict.

Run: ``OMP_NUM_THREADS=1 python benchmarks/verdict_changes.py [--revision 9153384] [BOARD ...]``

Three runs a board, with the ``smt-aqueous`` of their revision: the earlier revision's program judged by itself, the
same program, recipe and parameters judged by what stands now (so that only model and rules differ), and the program
that is planned now with the parameters of now. For each step the counts, and each change of a verdict with the rules
that were broken before and are broken after; in the end what is not clean, with its rules.
"""

import argparse
import gzip
import json
import os
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

_ROOT = Path(__file__).parents[1]
_BOARDS = ("tiny", "sensor-hub", "smt-demo", "two-sided", "radio-stick")
_WORK = """
import json, sys
from pathlib import Path
from boards.load import load_board
from cleaning.analyse import analyse
from programs.load import load_program
from recipes.load import load_recipe
try:
    from cleaning.parameters.load import load_parameters
    from programs.native import render
    from rulesengine.planning.pipeline import run
except ImportError:  # the earlier revision
    from cleaning.load import load_parameters
    from programs.posts.native import render
    from rulesengine.pipeline import run
board, recipe, parameters, program = (Path(word) for word in sys.argv[1:])
board, recipe = load_board(board), load_recipe(recipe)
if not program.exists():
    program.write_text(render(run(recipe, board).program))
report = analyse(load_program(program), board, recipe, load_parameters(parameters))
rule_of = lambda each: each.rule if isinstance(each.rule, str) else each.rule.id
print(json.dumps({
    part.component: [part.verdict, sorted({rule_of(each) for each in part.judgements if each.verdict != "clean"})]
    for part in report.parts
}))
"""
Verdicts = dict[str, tuple[str, list[str]]]


def analysed(root: Path, *files: Path) -> Verdicts:
    """Verdict and broken rules of each component, by the code of a checkout."""
    words = [sys.executable, "-c", _WORK, *map(str, files)]
    environment = {**os.environ, "PYTHONPATH": str(root)}
    done = subprocess.run(words, env=environment, cwd=root, check=True, stdout=subprocess.PIPE, text=True)
    return json.loads(done.stdout.splitlines()[-1])


def counts(verdicts: Verdicts) -> str:
    found = Counter(verdict for verdict, _ in verdicts.values())
    return " / ".join(str(found[each]) for each in ("dirty", "marginal", "no verdict", "clean"))


def changes(before: Verdicts, after: Verdicts) -> list[str]:
    """Each kind of change: how many components, from which verdict by which rules to which."""
    kinds: Counter[tuple[str, str]] = Counter()
    for name, (verdict, rules) in before.items():
        now, broken = after[name]
        if now != verdict:
            kinds[f"{verdict} ({' '.join(rules)})", f"{now} ({' '.join(broken)})".replace(" ()", "")] += 1
    return [f"    {count:4} {old} -> {new}" for (old, new), count in kinds.most_common()]


def main(words: list[str]) -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("boards", nargs="*", default=_BOARDS)
    parser.add_argument("--revision", default="9153384")
    arguments = parser.parse_args(words)
    print("dirty / marginal / no verdict / clean")
    with tempfile.TemporaryDirectory() as name:
        then = Path(name) / "then"
        then.mkdir()
        archive = subprocess.run(["git", "archive", arguments.revision], cwd=_ROOT, check=True, capture_output=True)
        subprocess.run(["tar", "-x", "-C", then], input=archive.stdout, check=True)
        recipe, parameters = Path("recipes/library/smt-aqueous.yaml"), Path("cleaning/library/default.yaml")
        for word in arguments.boards:
            board = Path(name) / f"{word}.tri"
            packed = _ROOT / "boards/library" / f"{word}.tri.gz"
            board.write_bytes(
                gzip.decompress(packed.read_bytes()) if packed.exists() else packed.with_suffix("").read_bytes()
            )
            old, new = (Path(name) / f"{word}-{which}.wash" for which in ("old", "new"))
            first = analysed(then, board, then / recipe, then / parameters, old)
            second = analysed(_ROOT, board, then / recipe, then / parameters, old)
            third = analysed(_ROOT, board, _ROOT / recipe, _ROOT / parameters, new)
            print(f"{word}: {counts(first)}; judged as now: {counts(second)}", *changes(first, second), sep="\n")
            print(f"  with the recipe of now: {counts(third)}", *changes(second, third), sep="\n")
            left = Counter((verdict, " ".join(rules)) for verdict, rules in third.values() if verdict != "clean")
            causes = (f"{count} {verdict} ({rules})" for (verdict, rules), count in left.most_common())
            print(f"  left: {', '.join(causes) or 'nothing'}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
