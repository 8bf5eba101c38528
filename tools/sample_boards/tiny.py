"""``tiny``: the smallest board that has one part of each kind."""

from sample_boards.assemble import Place, Sample
from sample_boards.shapes import rectangle

TINY = Sample(
    name="tiny",
    outline=rectangle((30.0, 20.0), (15.0, 10.0)),
    holes=(),
    bottom=-1.0,
    top=0.0,
    places=(
        Place("U1", "QFN-16-1EP_3x3mm_P0.5mm", 9.0, 12.0, 0.0, "SENSOR"),
        Place("C1", "C_0805_2012Metric", 14.5, 12.0, 90.0, "10u"),
        Place("R1", "R_0603_1608Metric", 9.0, 6.0, 30.0, "10k"),
        Place("R2", "R_0603_1608Metric", 17.0, 5.0, 0.0, "10k"),
        Place("J1", "PinHeader_1x04_P2.54mm_Vertical", 25.0, 10.0, 90.0),
    ),
)
