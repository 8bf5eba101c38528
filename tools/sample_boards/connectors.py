"""Sample parts that stand high or go through the board: headers, ports, switches, clamps."""

from sample_boards.shape import Shape
from sample_boards.shapes import bar, block, prism, rectangle, turned

from geometry.arrays import Triangles

PITCH = 2.54


def pin_header(rows: int, columns: int) -> Shape:
    """Make a standing pin header of 2.54 mm: ``columns`` pins along x in one or two rows."""
    xs = [(k - (columns - 1) / 2) * PITCH for k in range(columns)]
    ys = [((rows - 1) / 2 - k) * PITCH for k in range(rows)]
    places = [(x, y) for x in xs for y in ys]
    strip = block((columns * PITCH, rows * PITCH), 0.1, 2.54)
    pins = tuple(block((0.64, 0.64), -3.0, 8.54, place) for place in places)
    drills = tuple((x, y, 1.0) for x, y in places)
    package = f"PinHeader_{rows}x{columns:02d}_P2.54mm_Vertical"
    return Shape(package, rows * columns, 0.1, (("body", (strip,)), ("pins", pins)), drills)


def port(size: tuple[float, float, float], wall: float, pegs: tuple[tuple[float, float], ...], package: str) -> Shape:
    """Make a right-angle port with an open front (towards -y) that goes through the board with pegs.

    Args:
        size: Width along x, depth along y, height over the board.
        wall: Thickness of the shell.
        pegs: Where the pegs are.
        package: Name of the package; its family gives no number of pins, the pegs count.
    """
    width, _, height = size
    shell = _shell(size, wall, 0.3)
    tongue = block((width * 0.7, size[1] * 0.6), height * 0.55, height * 0.72, (0.0, size[1] * 0.1))
    posts = tuple(turned([(0.5, -2.6), (0.5, 0.3)], 8, place) for place in pegs)
    drills = tuple((x, y, 1.3) for x, y in pegs)
    solids = (("shell", shell), ("tongue", (tongue,)), ("pins", posts))
    return Shape(package, len(pegs), 0.3, solids, drills, overhang_mm=3.0)


def surface_port(size: tuple[float, float, float], pins: int, package: str) -> Shape:
    """Make a right-angle port with an open front (towards -y) that is soldered to the surface only."""
    width, depth, height = size
    back = depth / 2
    leads = [block((0.4, 1.2), 0.0, 0.15, ((k - (pins - 1) / 2) * 0.65, back + 0.3)) for k in range(pins)]
    wings = [block((0.9, 1.6), 0.0, 0.15, (x, 0.0)) for x in (-width / 2, width / 2)]
    tongue = block((width * 0.6, depth * 0.6), height * 0.5, height * 0.65, (0.0, depth * 0.1))
    solids = (("shell", _shell(size, 0.3, 0.15)), ("tongue", (tongue,)), ("terminals", (*leads, *wings)))
    return Shape(package, pins, 0.15, solids, overhang_mm=1.0)


def push_button(side: float, height: float, package: str) -> Shape:
    """Make a tactile switch with a round button and four flat terminals."""
    corners = [(x, y) for x in (-side / 2 - 0.5, side / 2 + 0.5) for y in (-side * 0.36, side * 0.36)]
    terminals = tuple(block((1.4, 0.7), 0.0, 0.12, corner) for corner in corners)
    body = prism(rectangle((side, side), corner=0.6), 0.12, 3.4)
    button = turned([(1.75, 3.4), (1.75, height)], 16)
    return Shape(package, 4, 0.12, (("body", (body,)), ("button", (button,)), ("terminals", terminals)))


def clamp(reach: float, width: float, thickness: float) -> Triangles:
    """Make a clamp that holds the left edge of a board at x = 0 whose top is z = 0 and whose bottom is -thickness."""
    low = -thickness
    profile = [
        (-8.0, low - 4.0),
        (reach, low - 4.0),
        (reach, low),
        (0.0, low),
        (0.0, 0.0),
        (reach, 0.0),
        (reach, 2.0),
        (-3.0, 4.0),
        (-8.0, 4.0),
    ]
    return bar(profile, width)


def _shell(size: tuple[float, float, float], wall: float, low: float) -> tuple[Triangles, ...]:
    """Make a tunnel along y and the wall that closes it, a little way in from the back."""
    width, depth, height = size
    inside, middle = (width - 2 * wall, height - low - 2 * wall), (low + height) / 2
    outer = rectangle((width, height - low), (0.0, middle))
    tunnel = bar(outer, depth, [rectangle(inside, (0.0, middle))])
    back = block((inside[0], 2 * wall), low + wall, height - wall, (0.0, depth / 2 - 0.1 - wall))
    return tunnel, back
