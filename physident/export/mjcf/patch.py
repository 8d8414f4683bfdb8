"""Writes a model's values into a user's own MJCF; comments, assets, actuators, sensors and layout stay as they are."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.export.mjcf.match import CLOSE, Match, match
from physident.export.mjcf.mjcf import STIFF, MjcfExport, child_links
from physident.export.mjcf.values import MjcfValues, element, inertial, mjcf_values, numbers
from physident.export.mjcf.verify import check_dynamics
from physident.export.mujoco import mujoco_module
from physident.export.urdf_edit import Edit, Element, child_edits, edited, marked, parse_elements
from physident.files import read_text
from physident.outputs import write_with
from physident.robots.inertia import link_parameters, pseudo_inertia

Array = NDArray[np.float64]
LIMIT = 20_000_000  # bytes
MASSLESS = element("inertial", {"pos": "0 0 0", "mass": "0", "diaginertia": "0 0 0"})
EXPECTED = "an MJCF file that MuJoCo reads"


@dataclass(frozen=True, eq=False)
class _Place:
    """A joint in the text: its element and that of the body that it moves."""

    joint: Element
    body: Element


def patch_mjcf(model: Model | Estimate, source: str | Path, target: str | Path | None = None) -> MjcfExport:
    """Write a model's values into the MJCF file ``source``, or into a copy of it at ``target`` in the same folder.

    Joints are found by name; each joint's body gets the inertia of all that moves with it, in that body's own frame. Values
    that the model does not state stay as they are. Raises InputError where MuJoCo cannot read the file, where its
    kinematics are not those of the robot, and where the patched file would not have the model's dynamics.
    """
    model = model.model if isinstance(model, Estimate) else model
    source = Path(source)
    target = source if target is None else Path(target)
    if target.resolve().parent != source.resolve().parent:
        raise InputError(
            f"output {str(target)!r} lies in another folder than {source}; expected the same one, which its assets are named from"
        )
    text = read_text(source, LIMIT, EXPECTED)
    compiled = _compiled(source, str(source))
    found = match(model.robot, compiled, str(source))
    _check_gravity(model, compiled, found, str(source))
    places = _places(text, str(source))
    if missing := [name for name in model.robot.joint_names if name not in places]:
        raise InputError(
            f"{source}: joint {missing[0]!r} is in a file that it includes; patch that file, or write the model out as one file"
        )
    values = mjcf_values(model, child_links(model.robot))
    patched = edited(text, _edits(text, model, values, found, places))
    if target.resolve() != source.resolve():  # the user's own file stays the user's
        patched = marked(patched)

    def write(temporary: Path) -> None:
        temporary.write_text(patched, encoding="utf-8")
        check_dynamics(_compiled(temporary, str(source)), model, values, found, str(source))

    write_with(target, write)
    more = _notes(compiled, model, found, places)
    return MjcfExport(patched, (*values.stated, *more), values.held)


def _check_gravity(model: Model, compiled: Any, found: Match, source: str) -> None:
    stated, there = np.array(model.robot.gravity), compiled.opt.gravity @ found.base
    tilted = any(model.added_inertia().gravity)  # the model's gravity is written then
    if not tilted and not np.allclose(stated, there, atol=CLOSE * np.linalg.norm(stated)):
        raise InputError(
            f"{source}: gravity in the arm's base frame is {np.round(there, 4).tolist()} m/s^2, in the model {stated.tolist()}; expected the arm mounted as in the model's description"
        )


def _compiled(path: Path, source: str) -> Any:
    mujoco = mujoco_module()

    try:
        return mujoco.MjModel.from_xml_path(str(path))
    except Exception as error:  # the binding raises several kinds
        reason = " ".join(str(error).replace(str(path), source).split())[:300]
        raise InputError(f"{source}: not {EXPECTED} ({reason})") from None


def _places(text: str, source: str) -> dict[str, _Place]:
    """Every joint of the text by name, with the body around it."""
    if "<!ENTITY" in text:
        raise InputError(f"{source}: declares XML entities, which an MJCF file does not need; write them out")
    try:
        root = parse_elements(text)
    except expat.ExpatError as error:
        raise InputError(f"{source}: malformed XML ({error}); expected {EXPECTED}") from None
    return {
        joint.attributes["name"]: _Place(joint, body)
        for world in root.find_all("worldbody")
        for body in _bodies(world)
        for joint in _inside(body, "joint")
        if "name" in joint.attributes
    }


def _inside(parent: Element, tag: str) -> Iterator[Element]:
    """Children of one tag, including those inside a ``<frame>``."""
    for child in parent.children:
        if child.tag == tag:
            yield child
        elif child.tag == "frame":
            yield from _inside(child, tag)


def _bodies(parent: Element) -> Iterator[Element]:
    for body in _inside(parent, "body"):
        yield body
        yield from _bodies(body)


def _fixed_to(body: Element) -> Iterator[Element]:
    """The bodies that are fixed to a body: below it without a joint between."""
    for child in _inside(body, "body"):
        if not any(True for tag in ("joint", "freejoint") for _ in _inside(child, tag)):
            yield child
            yield from _fixed_to(child)


def _edits(text: str, model: Model, values: MjcfValues, found: Match, places: dict[str, _Place]) -> list[Edit]:
    data = text.encode("utf-8")
    edits: list[Edit] = []
    for j, name in enumerate(model.robot.joint_names):
        place, settings = places[name], dict(values.joints[j])
        if values.armature is not None:
            settings["armature"] = values.armature[j]
        texts = {key: numbers([value]) for key, value in settings.items()}
        if settings.get(
            "frictionloss"
        ):  # MuJoCo's own constraint is so soft that a joint creeps where dry friction holds it
            texts |= {key: value for key, value in STIFF.items() if key not in place.joint.attributes}
        edits += _attributes(data, place.joint, texts)
        into = np.linalg.inv(found.frames[j])
        phi = link_parameters(into @ pseudo_inertia(values.links[j]) @ into.T)
        edits += child_edits(data, place.body, "inertial", element("inertial", inertial(phi)))
        for other in _fixed_to(place.body):
            if other.find_all("inertial") or list(_inside(other, "geom")):
                edits += child_edits(data, other, "inertial", MASSLESS)
    root = parse_elements(text)
    if any(model.added_inertia().gravity):
        edits += _gravity(data, root, found.base @ values.gravity)
    return edits + _tendons(data, root, model, values)


def _attributes(data: bytes, one: Element, settings: dict[str, str]) -> list[Edit]:
    """The edits that set attributes in an element's start tag and leave the others, and its layout, as they are."""
    stop = _tag_end(data, one.start)
    edits, new = [], ""
    for key, value in settings.items():
        if key in one.attributes:
            pattern = rb"\s" + key.encode() + rb"\s*=\s*(\"[^\"]*\"|'[^']*')"
            place = re.compile(pattern).search(data, one.start, stop)
            assert place is not None
            edits.append(Edit(place.start(1), place.end(1), f'"{value}"'))
        else:
            new += f' {key}="{value}"'
    if new:
        end = stop - 2 if data[stop - 2 : stop] == b"/>" else stop - 1
        while data[end - 1 : end].isspace():
            end -= 1
        edits.append(Edit(end, end, new))
    return edits


def _tag_end(data: bytes, start: int) -> int:
    """The place after the ``>`` of a start tag; one inside an attribute's value does not count."""
    quote = b""
    for at in range(start, len(data)):
        letter = data[at : at + 1]
        if quote:
            quote = b"" if letter == quote else quote
        elif letter in (b'"', b"'"):
            quote = letter
        elif letter == b">":
            return at + 1
    raise AssertionError("a parsed start tag has an end")


def _gravity(data: bytes, root: Element, gravity: Array) -> list[Edit]:
    options = root.find_all("option")
    stated = [option for option in options if "gravity" in option.attributes] or options[:1]
    if stated:
        return _attributes(data, stated[-1], {"gravity": numbers(gravity)})
    return child_edits(data, root, "option", element("option", {"gravity": numbers(gravity)}))


def _tendons(data: bytes, root: Element, model: Model, values: MjcfValues) -> list[Edit]:
    """Edits for pairs of joints that a motor turns together: the tendon of this pair, or a new one."""
    edits: list[Edit] = []
    new: list[str] = []
    fixed = [tendon for section in root.find_all("tendon") for tendon in section.find_all("fixed")]
    for joints, pair in values.pairs.items():
        names = [model.robot.joint_names[j] for j in joints]
        settings = {key: numbers([value]) for key, value in pair.items()}
        known = [
            t for t in fixed if sorted(j.attributes.get("joint", "") for j in t.find_all("joint")) == sorted(names)
        ]
        if known:
            edits += _attributes(data, known[0], settings)
            continue
        wraps = "".join(f"  {element('joint', {'joint': name, 'coef': '1'})}\n" for name in names)
        head = element("fixed", {"name": "_and_".join(names), **settings, **STIFF}, open=True)
        new.append(f"{head}\n{wraps}</fixed>")
    for text in new:
        block = "  <tendon>\n    " + text.replace("\n", "\n    ") + "\n  </tendon>\n"
        edits.append(Edit(root.end, root.end, block))
    return edits


def _notes(compiled: Any, model: Model, found: Match, places: dict[str, _Place]) -> list[str]:
    notes = []
    for number, name in enumerate(model.robot.joint_names, 1):
        others = [b.attributes.get("name", "?") for b in _fixed_to(places[name].body) if b.children]
        if others:
            notes.append(f"bodies fixed to joint {number}'s body, now without mass: {', '.join(others)}")
    if compiled.nv != model.robot.n:
        notes.append(
            f"the file has {compiled.nv - model.robot.n} more degrees of freedom than the model; their bodies keep their inertia, which the model's last link may include too"
        )
    return notes
