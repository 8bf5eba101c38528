"""Robots from URDF files: the chain of joints from a base link to a flange link, and the collision bodies.

Fixed joints are folded. A moving joint that is not on the chain, such as a finger's, stands at zero. Inertias,
transmissions and visual shapes are not read. A URDF states no accelerations: those of the joints are infinite until
something else states them.
"""

import math
from collections import Counter
from dataclasses import dataclass, field, replace
from pathlib import Path
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray

from robotcell.errors import CellError
from robotcell.robot.meshes import cylinder_triangles, read_mesh
from robotcell.robot.robot import Body, Box, Capsule, Joint, Mesh, Poses, Robot, inverse, pose
from specs.confinement import refusal
from specs.input_file import InputFile
from specs.spec import write_number

_MOVING = ("revolute", "continuous", "prismatic")
_LARGEST_TEXT = 5_000_000
_DEEPEST = 100
_FARTHEST_M = 100.0
"""No place and no size of a robot is larger, as in a cell."""

_LARGEST_NUMBER = 1e6
"""Of the others: directions, angles, limits, speeds, scales."""


@dataclass(frozen=True, slots=True, eq=False)
class Element:
    """An element of an XML file, with its line."""

    tag: str
    attributes: dict[str, str]
    file: Path
    line: int
    children: "list[Element]" = field(default_factory=list["Element"])

    def all(self, tag: str) -> "list[Element]":
        """Give the children with a tag, in the order of the file."""
        return [child for child in self.children if child.tag == tag]

    def first(self, tag: str) -> "Element | None":
        """Give the first child with a tag, ``None`` if there is none."""
        return next(iter(self.all(tag)), None)

    def need(self, tag: str) -> "Element":
        """Give the first child with a tag.

        Raises:
            CellError: there is none.
        """
        child = self.first(tag)
        if child is None:
            raise self.error(f"has no <{tag}>; add one")
        return child

    def text(self, name: str) -> str:
        """Give an attribute.

        Raises:
            CellError: it is missing.
        """
        if name not in self.attributes:
            raise self.error(f"has no {name}; add {name}=...")
        return self.attributes[name]

    def error(self, message: str) -> CellError:
        """Give the error of this element: file, line, tag and name, then the message."""
        named = self.attributes.get("name")
        label = f"<{self.tag} name={named!r}>" if named else f"<{self.tag}>"
        return CellError(f"{label} {message}", file=self.file, line=self.line)


def read_xml(file: Path) -> Element:
    """Read an XML file as a tree of elements; a document type, and with it every entity, is refused.

    Raises:
        CellError: it cannot be read, is too large, too deep or no XML.
    """
    text = InputFile(file, CellError, "URDF", _LARGEST_TEXT).read()
    parser = expat.ParserCreate()
    top = Element("", {}, file, 1)
    opened = [top]

    def begin(tag: str, attributes: dict[str, str]) -> None:
        if len(opened) > _DEEPEST:
            raise CellError(f"nested more than {_DEEPEST} deep", file=file, line=parser.CurrentLineNumber)
        element = Element(tag, attributes, file, parser.CurrentLineNumber)
        opened[-1].children.append(element)
        opened.append(element)

    def end(_: str) -> None:
        opened.pop()

    def refuse(*_: object) -> None:
        raise CellError("a <!DOCTYPE ...> is not allowed; remove it", file=file, line=parser.CurrentLineNumber)

    parser.StartElementHandler, parser.EndElementHandler, parser.StartDoctypeDeclHandler = begin, end, refuse
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        raise CellError(f"not valid XML: {expat.errors.messages[error.code]}", file=file, line=error.lineno) from None
    except (LookupError, ValueError):  # the encoding that it states is unknown to Python, or of several bytes
        raise CellError("is in an encoding that is not read here; save it as UTF-8", file=file, line=1) from None
    return top.children[0]


@dataclass(frozen=True, slots=True, eq=False)
class _Tree:
    """The links and joints of one file."""

    links: dict[str, Element]
    above: dict[str, Element]
    """The parent joint of each link, by the link's name."""
    root: str

    def joints_to(self, link: str) -> list[Element]:
        """Joints from the root to a link.

        Raises:
            CellError: they lead to it from themselves.
        """
        found: list[Element] = []
        while link in self.above:
            found.append(self.above[link])
            link = found[-1].need("parent").text("link")
            if len(found) > len(self.above):
                raise found[0].error("is part of a circle of joints; a robot is a tree")
        return found[::-1]

    def carrier(self, link: str, moving: list[Element]) -> tuple[int, Poses]:
        """Give the number of the moving joint that carries a link (0: none), and the link's (4, 4) pose on it."""
        carrier, T_carrier_link = 0, np.eye(4)
        for joint in self.joints_to(link):
            if joint in moving:
                carrier, T_carrier_link = moving.index(joint) + 1, np.eye(4)
            else:
                T_carrier_link = T_carrier_link @ read_origin(joint)
        return carrier, T_carrier_link


def read_urdf(file: Path, *, base_link: str | None = None, flange_link: str | None = None) -> Robot:
    """Read a robot.

    Args:
        file: The URDF; meshes are looked for in its folder.
        base_link: Link whose frame is the robot's base; the root of the tree if left out.
        flange_link: Link whose frame is the flange; if left out, the only link that carries no other.

    Raises:
        CellError: it cannot be read, or holds no such chain; the message names file, line and element.
    """
    top = read_xml(file)
    _refuse_xacro(top)
    if top.tag != "robot":
        raise top.error("is not what a URDF begins with: <robot name=...>")
    tree = _read_tree(top)
    parents = {joint.need("parent").text("link") for joint in tree.above.values()}
    ends = [name for name in tree.links if name not in parents]
    if not flange_link and len(ends) != 1:
        raise top.error(f"ends in several links; state flange_link, one of {', '.join(ends)}")
    base, flange = base_link or tree.root, flange_link or ends[0]
    for name in (base, flange):
        if name not in tree.links:
            raise top.error(f"has no link {name!r}; it has {', '.join(tree.links)}")
    moving = [joint for joint in tree.joints_to(flange) if joint.text("type") in _MOVING]
    if not moving:
        raise tree.links[flange].error(f"is not moved by any joint: no chain from {base} to {flange}")
    carried = {name: tree.carrier(name, moving) for name in tree.links}
    carrier, T_carrier_base = carried[base]
    if carrier != 0:
        raise tree.links[base].error(f"moves with joint {moving[carrier - 1].text('name')}; a base stands still")
    T_base_carrier = inverse(T_carrier_base)
    bodies: list[list[Body]] = [[] for _ in range(len(moving) + 1)]
    for name, (index, T_carrier_link) in carried.items():
        place = T_base_carrier @ T_carrier_link if index == 0 else T_carrier_link
        bodies[index] += read_bodies(tree.links[name], place)
    joints = [_read_joint(element, carried[element.need("parent").text("link")][1]) for element in moving]
    joints[0] = replace(joints[0], T_parent_joint=T_base_carrier @ joints[0].T_parent_joint)
    name = top.attributes.get("name", file.stem)
    return Robot(name, tuple(joints), carried[flange][1], tuple(tuple(each) for each in bodies))


def _refuse_xacro(element: Element) -> None:
    """Refuse a file that is still to be expanded: macros and properties have to be carried out first.

    Raises:
        CellError: an element is one of xacro's.
    """
    if element.tag.startswith("xacro:"):
        file = element.file
        urdf = f"{file.name.removesuffix('.xacro').removesuffix('.urdf')}.urdf"
        commands = f"`xacro {file.name} -o {urdf}` of ROS, or `pipx run xacrodoc {file.name} -o {urdf}` without it"
        raise element.error(f"is xacro, from which a URDF is made first: {commands}; then name {urdf}")
    for child in element.children:
        _refuse_xacro(child)


def _read_tree(top: Element) -> _Tree:
    for kind in ("link", "joint"):
        for name, count in Counter(each.text("name") for each in top.all(kind)).items():
            if count > 1:
                raise top.error(f"has {count} {kind}s named {name!r}; names are unique")
    links = {link.text("name"): link for link in top.all("link")}
    above: dict[str, Element] = {}
    for joint in top.all("joint"):
        for end in ("parent", "child"):
            if joint.need(end).text("link") not in links:
                raise joint.need(end).error(f"names a link {joint.need(end).text('link')!r} that is not there")
        child = joint.need("child").text("link")
        if child in above:
            raise joint.error(f"moves link {child!r}, the child of joint {above[child].text('name')!r} already")
        above[child] = joint
    roots = [name for name in links if name not in above]
    if len(roots) != 1:
        found = ", ".join(roots) if roots else "none: the joints go in a circle"
        raise top.error(f"needs exactly one root link; found {found}")
    tree = _Tree(links, above, roots[0])
    for name in links:
        tree.joints_to(name)  # refuses circles
    return tree


def _read_joint(element: Element, T_carrier_parent: Poses) -> Joint:
    kind = element.text("type")
    if element.first("mimic") is not None:
        raise element.error("mimics another joint; a chain's joints move by themselves")
    stated = element.first("axis")
    axis = np.array([1.0, 0.0, 0.0]) if stated is None else read_numbers(stated, "xyz", 3)
    length = float(np.linalg.norm(axis))
    if length < 1e-9:
        raise element.error("has an axis without direction; give one, such as xyz='0 0 1'")
    limit = element.need("limit")
    lowest, highest = -math.inf, math.inf
    if kind != "continuous":
        lowest, highest = (float(read_numbers(limit, end, 1)[0]) for end in ("lower", "upper"))
    if lowest >= highest:
        raise limit.error(f"has lower {lowest:g} not below upper {highest:g}")
    speed = float(read_numbers(limit, "velocity", 1)[0])
    if speed <= 0:
        raise limit.error(f"has velocity {speed:g}; the greatest speed is above 0")
    return Joint(
        name=element.text("name"),
        kind="prismatic" if kind == "prismatic" else "revolute",
        T_parent_joint=T_carrier_parent @ read_origin(element),
        axis=axis / length,
        lowest=lowest,
        highest=highest,
        speed=speed,
        acceleration=math.inf,
    )


def read_bodies(link: Element, T_carrier_link: Poses) -> list[Body]:
    """Read the collision bodies of a link; each is named after the link unless it has a name of its own.

    Raises:
        CellError: a shape is of an unknown kind, or its mesh cannot be read.
    """
    bodies: list[Body] = []
    for each in link.all("collision"):
        geometry = each.need("geometry")
        if len(geometry.children) != 1:
            raise geometry.error(f"holds {len(geometry.children)} shapes; it takes one")
        element = geometry.children[0]
        match element.tag:
            case "box":
                x, y, z = _sizes(element, "size", 3)
                shape = Box((x, y, z))
            case "sphere":
                shape = Capsule(_sizes(element, "radius", 1)[0], 0.0)
            case "capsule":  # as in SDF: the length is that between the centres of its round ends
                shape = Capsule(_sizes(element, "radius", 1)[0], _sizes(element, "length", 1)[0])
            case "cylinder":
                shape = Mesh(cylinder_triangles(_sizes(element, "radius", 1)[0], _sizes(element, "length", 1)[0]))
            case "mesh":
                scale = read_numbers(element, "scale", 3) if "scale" in element.attributes else np.ones(3)
                shape = Mesh(read_mesh(_find_mesh(element)) * scale)
                if not (np.abs(shape.triangles) <= _FARTHEST_M).all():
                    hint = "a mesh in mm takes scale='0.001 0.001 0.001'"
                    raise element.error(f"reaches farther than {_FARTHEST_M:g} m; {hint}")
            case _:
                raise element.error("is not a shape that is known: box, sphere, capsule, cylinder, mesh")
        name = each.attributes.get("name", link.text("name"))
        bodies.append(Body(name, shape, T_carrier_link @ read_origin(each)))
    return bodies


def read_origin(element: Element) -> Poses:
    """Read the (4, 4) pose of an element's <origin>; the identity if it has none."""
    origin = element.first("origin")
    if origin is None:
        return np.eye(4)
    xyz, rpy = (
        read_numbers(origin, name, 3, most) if name in origin.attributes else np.zeros(3)
        for name, most in (("xyz", _FARTHEST_M), ("rpy", _LARGEST_NUMBER))
    )
    return pose(xyz.tolist(), rpy.tolist())


def read_numbers(element: Element, name: str, count: int, most: float = _LARGEST_NUMBER) -> NDArray[np.float64]:
    """Read an attribute of ``count`` numbers from ``-most`` to ``most``.

    Raises:
        CellError: it is missing, or holds something else.
    """
    text = element.text(name)
    try:
        numbers = np.array([float(word) for word in text.split()])
    except ValueError:
        numbers = np.empty(0)
    if len(numbers) != count or not (np.abs(numbers) <= most).all():
        noun = "finite number" if count == 1 else "finite numbers"
        bounds = f"from {write_number(-most)} to {write_number(most)}"
        raise element.error(f"has {name}={text[:40]!r}; it takes {count} {noun} {bounds}")
    return numbers


def _sizes(shape: Element, name: str, count: int) -> list[float]:
    numbers = read_numbers(shape, name, count, _FARTHEST_M)
    if (numbers <= 0).any():
        raise shape.error(f"has {name}={shape.text(name)[:40]!r}; sizes are above 0")
    return numbers.tolist()


def _find_mesh(shape: Element) -> Path:
    """Find a mesh beside the URDF; ``package://`` means the URDF's folder or the one that holds it."""
    name = shape.text("filename")
    folder = shape.file.parent.resolve()
    folders, inside = [folder], name
    if name.startswith("package://"):
        inside = name.removeprefix("package://").partition("/")[2]
        folders.append(folder.parent)
    elif "://" in name or Path(name).is_absolute():
        raise shape.error(f"names {name!r}; give a path from the URDF's folder, or package://...")
    if "\0" in inside:
        raise shape.error(f"names {name!r}, which cannot be a file")
    for each in folders:
        file = (each / inside).resolve()
        if not file.is_relative_to(each):
            raise shape.error(f"names {name!r}, which is outside the URDF's folder; copy it there")
        if reason := refusal(file):
            raise shape.error(f"names {name!r}, which {reason}")
        if file.is_file():
            return file
    looked = " or ".join(str(each / inside) for each in folders)
    raise shape.error(f"names {name!r}, which is not there: no file {looked}")
