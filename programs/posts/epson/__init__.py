"""Epson SPEL+."""

from programs.motion.lower import Capability
from programs.posts.dialect import Dialect, FileForm
from programs.posts.epson.read import SpelReader
from programs.posts.epson.write import Spel
from programs.timing.controller import Controller

DIALECT = Dialect(
    title="Epson SPEL+",
    notes="For RC+ 7 and 8; outputs as !Dn; On n! with each move. Tool and Local are set at the start; AccelS and "
    "AccelR are assumed, put the robot's own there. Analog outputs need the option board (AIO_Out).",
    capability=Capability(
        controller_class=2,
        timing="percent",
        cycle_s=0.002,  # assumed
        step_percent=1.0,
        most_events=16,  # Dn may appear 16 times in one statement (SPEL+ reference for RC800)
        step_mm_s=0.1,
    ),
    form=FileForm(".prg"),
    longest_line=240,  # RC+ takes more; assumed
    most_steps=1500,  # of a file; assumed
    write=Spel.write,
    rebuild=SpelReader.rebuild,
    controller=Controller(
        blending="overlap",
        acceleration_mm_s2=2000.0,
        turn_acceleration_deg_s2=1000.0,
        joint_speed_share=0.1,
        settle_s=0.05,
        look_ahead=10,
        least_line_s=0.008,
        most_lines=20_000,
        sources={
            "acceleration_mm_s2": "AccelS of the program's text",
            "turn_acceleration_deg_s2": "AccelR of the program's text",
        },
    ),
    maker="epson",
)
