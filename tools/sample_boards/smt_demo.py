"""``smt-demo``: a dense surface-mount controller board of 100 x 80 mm, held by two clamps."""

from sample_boards.assemble import Place, Sample, row
from sample_boards.connectors import clamp
from sample_boards.shapes import circle, rectangle, rotated, rounded, shifted

_PORTS = (
    Place("J1", "USB_A_Horizontal", 18.0, 5.1),
    Place("J2", "RJ45_Magnetics_Horizontal", 46.0, 8.15),
    Place("J3", "PinHeader_2x10_P2.54mm_Vertical", 50.0, 75.0),
    Place("J4", "PinHeader_1x06_P2.54mm_Vertical", 96.5, 40.0, 90.0),
    Place("SW1", "SW_PUSH_6mm_SMD", 71.0, 7.5),
    Place("SW2", "SW_PUSH_6mm_SMD", 83.0, 7.5),
    *row(Place("LED1", "LED_0805_2012Metric", 62.5, 4.0), 4, (0.0, 2.6)),
    *row(Place("R1", "R_0603_1608Metric", 59.0, 4.0, value="470R"), 4, (0.0, 2.6)),
)

_POWER = (
    Place("U12", "SOT-223", 9.0, 22.5, 90.0, "AMS1117-3.3"),
    Place("C1", "CP_Elec_6.3x7.7", 19.0, 18.5, 0.0, "220u"),
    Place("C2", "CP_Elec_8x10", 30.5, 18.5, 180.0, "470u"),
    Place("C3", "CP_Elec_8x10", 31.0, 7.0, 90.0, "470u"),
    Place("L1", "L_6.3x6.3_H3", 18.5, 28.5, 0.0, "10u"),
    Place("D1", "D_SMA", 27.0, 26.5, 0.0, "SS34"),
    Place("D2", "D_SMA", 8.5, 29.5, 180.0, "SS34"),
    Place("C4", "CP_EIA-6032-28_Kemet-C", 27.0, 31.0, 0.0, "100u"),
    Place("C5", "CP_EIA-3216-18_Kemet-A", 35.5, 26.0, 90.0, "10u"),
    Place("C6", "C_1210_3225Metric", 8.0, 14.5, 0.0, "22u"),
    *row(Place("C7", "C_1206_3216Metric", 5.0, 34.0, 90.0, "10u"), 3, (2.4, 0.0)),
    Place("R5", "R_1206_3216Metric", 31.0, 13.2, 0.0, "0R1"),
)

_PROCESSOR = (
    Place("U1", "LQFP-100_14x14mm_P0.5mm", 50.0, 43.0, 0.0, "MCU"),
    Place("U4", "BGA-144_13x13mm_P1.0mm", 50.0, 62.0, 0.0, "FPGA"),
    *row(Place("C10", "C_0402_1005Metric", 43.25, 53.2, 90.0, "100n"), 10, (1.5, 0.0)),
    *row(Place("C20", "C_0402_1005Metric", 43.25, 32.8, 90.0, "100n"), 10, (1.5, 0.0)),
    *row(Place("C30", "C_0402_1005Metric", 42.2, 57.6, 0.0, "100n"), 12, (0.0, 0.8)),
    *row(Place("C42", "C_0402_1005Metric", 57.8, 57.6, 0.0, "100n"), 12, (0.0, 0.8)),
    *row(Place("C54", "C_0603_1608Metric", 39.8, 58.5, 0.0, "1u"), 4, (0.0, 2.0)),
    *row(Place("C58", "C_0805_2012Metric", 60.6, 58.5, 0.0, "10u"), 4, (0.0, 2.25)),
    Place("Y1", "Crystal_SMD_3225-4Pin_3.2x2.5mm", 64.0, 46.0, 90.0, "25M"),
    Place("C62", "C_0402_1005Metric", 64.0, 48.6, 0.0, "18p"),
    Place("C63", "C_0402_1005Metric", 64.0, 43.4, 0.0, "18p"),
    *row(Place("R10", "R_0402_1005Metric", 60.5, 36.0, 0.0, "33R"), 8, (0.0, 0.9)),
)

_LEFT = (
    Place("U3", "LQFP-48_7x7mm_P0.5mm", 20.0, 58.0, 45.0, "CODEC"),
    Place("C64", "C_0603_1608Metric", 24.5, 62.5, 135.0, "100n"),
    Place("C65", "C_0603_1608Metric", 15.5, 62.5, 45.0, "100n"),
    Place("C66", "C_0603_1608Metric", 15.5, 53.5, 315.0, "100n"),
    Place("C67", "C_0603_1608Metric", 24.5, 53.5, 225.0, "100n"),
    Place("U6", "QFN-48-1EP_7x7mm_P0.5mm", 20.0, 40.0, 0.0, "PHY"),
    *row(Place("C70", "C_0402_1005Metric", 17.2, 45.0, 90.0, "100n"), 7, (0.9, 0.0)),
    *row(Place("R20", "R_0402_1005Metric", 25.0, 37.3, 0.0, "49R9"), 7, (0.0, 0.9)),
    Place("U7", "SOIC-8_3.9x4.9mm_P1.27mm", 34.0, 33.0, 0.0, "EEPROM"),
    Place("U10", "TSSOP-20_4.4x6.5mm_P0.65mm", 33.5, 45.5, 0.0, "BUFFER"),
    Place("U11", "TSSOP-16_4.4x5mm_P0.65mm", 33.0, 65.0, 90.0, "UART"),
    Place("U13", "SOT-23-5", 8.0, 56.0, 0.0, "LDO"),
    Place("C68", "C_0603_1608Metric", 8.0, 59.0, 0.0, "1u"),
    Place("C69", "C_0603_1608Metric", 8.0, 53.0, 180.0, "1u"),
    *row(Place("D3", "D_MiniMELF", 12.0, 72.0, 90.0, "LL4148"), 4, (2.6, 0.0)),
    *row(Place("R30", "R_0603_1608Metric", 25.0, 72.0, 90.0, "10k"), 8, (1.3, 0.0)),
)

_RIGHT = (
    Place("U2", "LQFP-64_10x10mm_P0.5mm", 78.0, 51.0, 90.0, "DSP"),
    *row(Place("C80", "C_0402_1005Metric", 74.0, 59.0, 90.0, "100n"), 9, (1.0, 0.0)),
    *row(Place("R40", "R_0603_1608Metric", 73.5, 63.0, 90.0, "10k"), 8, (1.3, 0.0)),
    Place("U5", "QFN-32-1EP_5x5mm_P0.5mm", 78.0, 36.5, 270.0, "RADIO"),
    Place("C90", "C_0402_1005Metric", 82.0, 39.0, 45.0, "1p5"),
    Place("L2", "L_0603_1608Metric", 84.0, 36.5, 45.0, "4n7"),
    Place("C91", "C_0402_1005Metric", 82.0, 34.0, 315.0, "1p5"),
    Place("U8", "SOIC-14_3.9x8.7mm_P1.27mm", 64.0, 25.0, 0.0, "OPAMP"),
    Place("U9", "SOIC-16_3.9x9.9mm_P1.27mm", 76.0, 23.0, 180.0, "DRIVER"),
    *row(Place("Q1", "SOT-23", 85.0, 17.0, 0.0, "BC817"), 3, (0.0, 4.5)),
    *row(Place("Q4", "SOT-23", 91.0, 17.0, 180.0, "BC807"), 3, (0.0, 4.5)),
    *row(Place("R50", "R_0805_2012Metric", 88.0, 17.0, 90.0, "2k2"), 3, (0.0, 4.5)),
    Place("C92", "C_0805_2012Metric", 69.2, 25.0, 90.0, "100n"),
    Place("C93", "C_0805_2012Metric", 76.0, 29.3, 0.0, "100n"),
    Place("R53", "R_0805_2012Metric", 90.0, 52.0, 30.0, "120R"),
    Place("R54", "R_0805_2012Metric", 90.0, 56.0, 60.0, "120R"),
    Place("C94", "CP_EIA-3216-18_Kemet-A", 88.5, 46.5, 90.0, "10u"),
    *row(Place("C95", "C_0402_1005Metric", 72.0, 70.0, 90.0, "10n"), 9, (0.8, 0.0)),
)

_CLAMP = clamp(3.0, 12.0, 1.6)

SMT_DEMO = Sample(
    name="smt-demo",
    outline=rounded(rectangle((100.0, 80.0), (50.0, 40.0)), 2.0),
    holes=tuple(circle(1.6, 16, centre) for centre in ((4.0, 4.0), (96.0, 4.0), (4.0, 76.0), (96.0, 76.0))),
    bottom=-1.6,
    top=0.0,
    places=(*_PORTS, *_POWER, *_PROCESSOR, *_LEFT, *_RIGHT),
    clamps=(("CLAMP1", shifted(_CLAMP, 0.0, 44.0)), ("CLAMP2", shifted(rotated(_CLAMP, 180.0), 100.0, 60.0))),
)
