"""Small cells and robots for tests: a YAML text to change, and a URDF of two joints."""

from textwrap import indent

CELL = """cell: small
robot: ur5e
base: {rpy_deg: [0, 0, 180]}
home_deg_mm: [-16, -94, 97, -93, -90, -106]
board:
  pose: {xyz_mm: [400, -50, 150]}
tools:
  1:
    name: cone
    tcp: {xyz_mm: [0, 0, 180]}
    bodies:
      lance: {kind: capsule, from_mm: [0, 0, 0], to_mm: [0, 0, 170], radius_mm: 8}
fixtures:
  table: {kind: box, size_mm: [900, 900, 40], at: {xyz_mm: [300, 0, -20]}}
nozzles:
  ring60: {valve: doRing, round: true}
io:
  outputs:
    doRing: {kind: digital, number: 1}
    goSolution: {kind: group, number: 1}
    aoPressure: {kind: analog, number: 1}
  functions:
    clean: {doRing: 0}
  solutions:
    di-water: {goSolution: 2}
  settings:
    pressure_bar: {output: aoPressure, scale: 0.5}
  sensors:
    resistivity_mohm_cm: {input: aiRes, number: 3, scale: 2}
  inputs:
    diBoard: {number: 1}
    diDoor: {number: 2}
  waits:
    part_present: {input: diBoard}
    door_closed: {input: diDoor, state: 0, watched: true}
    water: {sensor: resistivity_mohm_cm, least: 0.5, timeout_s: 5}
"""

TWO_TCPS = (
    CELL.replace("cell: small", "cell: two-tcps")
    .replace(
        "fixtures:",
        """  2:
    name: knife
    tcp: {xyz_mm: [0, -60, 120], rpy_deg: [25, 0, 0]}
    bodies:
      pipe: {kind: capsule, from_mm: [0, 0, 0], to_mm: [0, -45, 100], radius_mm: 8}
fixtures:""",
    )
    .replace("clean: {doRing: 0}", "clean: {goSolution: 1}")
)
"""Two tools whose orifices are 85 mm and 25 degrees apart."""

LINKS = "".join(f'<link name="{name}"/>' for name in ("foot", "slide", "hand"))
JOINTS = """
<joint name="S" type="prismatic"><parent link="foot"/><child link="slide"/><origin xyz="0 0 0.5"/><axis xyz="0 0 1"/>
 <limit lower="-0.1" upper="0.2" velocity="0.5"/></joint>
<joint name="T" type="revolute"><parent link="slide"/><child link="hand"/>
 <origin xyz="0.3 0 0" rpy="0 0 0.5"/><axis xyz="0 0 2"/>
 <limit lower="-1" upper="1" velocity="2"/></joint>
"""


def urdf(links: str = LINKS, joints: str = JOINTS) -> str:
    """A robot of one sliding and one turning joint."""
    return f'<?xml version="1.0"?>\n<robot name="two">\n{indent(links + joints, " ")}</robot>\n'
