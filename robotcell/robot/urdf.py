"""Robots from URDF files: the chain of joints from a base link to a flange link, and what can collide.

Fixed joints are folded. A moving joint that is not on the chain, such as a finger's, stands at zero. Inertias,
transmissions and what is only for the eye are not read. A URDF knows no accelerations: those of the joints are
infinite until something else states them.
"""

import math
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from robotcell.errors import CellError
from robotcell.robot.poses import inverse
from robotcell.robot.robot import Body, Joint, Poses, Robot
from robotcell.robot.urdf_shapes import read_bodies, read_numbers, read_origin
from robotcell.robot.xml_tree import Element, read_xml

_MOVING = ("revolute", "continuous", "prismatic")


@dataclass(frozen=True, slots=True, eq=False)
class _Tree:
    """The links and joints of one file."""

    links: dict[str, Element]
    above: dict[str, Element]
    """The joint that each link hangs on, by the link's name."""
    root: str

    def joints_to(self, link: str) -> list[Element]:
        """Joints from the root to a link."""
        found: list[Element] = []
        while link in self.above:
            found.append(self.above[link])
            link = found[-1].need("parent").text("link")
        return found[::-1]


def read_urdf(file: Path, *, base_link: str | None = None, flange_link: str | None = None) -> Robot:
    """Read a robot.

    Args:
        file: The URDF; meshes are looked for in its folder.
        base_link: Link whose frame is the robot's base; the root of the tree if left out.
        flange_link: Link whose frame is the flange; if left out, the only link that carries no other.

    Raises:
        CellError: it cannot be read, or holds no such chain; the message names file, line and element.
    """
    top = read_xml(_read(file), file)
    if top.tag != "robot":
        raise top.error("is not what a URDF begins with: <robot name=...>")
    tree = _read_tree(top)
    base, flange = base_link or tree.root, flange_link or _only_end(top, tree)
    for name in (base, flange):
        if name not in tree.links:
            raise top.error(f"has no link {name!r}; it has {', '.join(tree.links)}")
    moving = [joint for joint in tree.joints_to(flange) if joint.text("type") in _MOVING]
    if not moving:
        raise tree.links[flange].error(f"is not moved by any joint: no chain from {base} to {flange}")
    carried = {name: _carrier(tree, name, moving) for name in tree.links}
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


def _read(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except FileNotFoundError:
        raise CellError("no such file; give the path of a URDF", file=file) from None
    except (OSError, ValueError) as error:
        raise CellError(f"cannot be read: {getattr(error, 'strerror', None) or error}", file=file) from None


def _read_tree(top: Element) -> _Tree:
    _refuse_twins(top)
    links = {link.text("name"): link for link in top.all("link")}
    above: dict[str, Element] = {}
    for joint in top.all("joint"):
        for end in ("parent", "child"):
            if joint.need(end).text("link") not in links:
                raise joint.need(end).error(f"names a link {joint.need(end).text('link')!r} that is not there")
        child = joint.need("child").text("link")
        if child in above:
            raise joint.error(f"moves link {child!r}, which hangs on joint {above[child].text('name')!r} already")
        above[child] = joint
    roots = [name for name in links if name not in above]
    if len(roots) != 1:
        found = ", ".join(roots) if roots else "none: the joints go in a circle"
        raise top.error(f"needs exactly one link that hangs on nothing; found {found}")
    _refuse_circles(roots[0], above)
    return _Tree(links, above, roots[0])


def _refuse_twins(top: Element) -> None:
    for kind in ("link", "joint"):
        for name, count in Counter(each.text("name") for each in top.all(kind)).items():
            if count > 1:
                raise top.error(f"has {count} {kind}s named {name!r}; names are unique")


def _refuse_circles(root: str, above: dict[str, Element]) -> None:
    reached, waiting = {root}, dict(above)
    while ready := [name for name, joint in waiting.items() if joint.need("parent").text("link") in reached]:
        reached.update(ready)
        for name in ready:
            del waiting[name]
    if waiting:
        raise next(iter(waiting.values())).error("is part of a circle of joints; a robot is a tree")


def _only_end(top: Element, tree: _Tree) -> str:
    parents = {joint.need("parent").text("link") for joint in tree.above.values()}
    ends = [name for name in tree.links if name not in parents]
    if len(ends) != 1:
        raise top.error(f"ends in several links; state flange_link, one of {', '.join(ends)}")
    return ends[0]


def _carrier(tree: _Tree, link: str, moving: list[Element]) -> tuple[int, Poses]:
    """Give which joint of the chain carries a link (0: none does, it stands), and the link's (4, 4) pose on that."""
    carrier, T_carrier_link = 0, np.eye(4)
    for joint in tree.joints_to(link):
        if joint in moving:
            carrier, T_carrier_link = moving.index(joint) + 1, np.eye(4)
        else:
            T_carrier_link = T_carrier_link @ read_origin(joint)
    return carrier, T_carrier_link


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
