"""A panel: several boards of one kind, sprayed together and judged apart.

python examples/09_a_panel.py [BOARD] [PITCH_MM]
"""

import sys
from pathlib import Path

import washboard as wb


def main(board: str = "tiny", pitch_mm: str = "60") -> None:
    """Write a panel of two boards, plan it, and compare it with the single board."""
    Path("panel.yaml").write_text(f"panel: {{board: {board}, nx: 2, pitch_mm: [{pitch_mm}, 0]}}\n", "utf-8")
    panel = wb.open_board("panel.yaml")
    together, alone = (wb.plan(each, "rinse-only") for each in (panel, board))
    print(f"{len(panel.instances)} boards, {len(panel.components)} components, such as {panel.components[-1].name}")
    print(f"{together.duration_s:.1f} s for both, {alone.duration_s:.1f} s for one")


if __name__ == "__main__":
    main(*sys.argv[1:])
