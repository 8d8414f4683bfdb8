"""Where the text of a robot's description comes from: built in, a file, a xacro file, or a package of descriptions."""

from __future__ import annotations

import contextlib
import importlib
import importlib.metadata
import importlib.util
import io
import os
import re
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Literal
from xml.parsers import expat

from physident.errors import InputError, did_you_mean
from physident.files import read_text
from physident.robots.urdf import MAX_BYTES

BUILT_IN = ("ur5", "ur10e")
PACKAGE = (
    "example-robot-data"  # its files come with it; robot_descriptions downloads a description when it is first used
)
PACKAGED = {  # arms of that package: the file, and the arm's joints where the robot has others
    "panda": ("panda_description/urdf/panda.urdf", ("panda_joint*",)),
    "ur3": ("ur_description/urdf/ur3_robot.urdf", None),
    "ur10": ("ur_description/urdf/ur10_robot.urdf", None),
    "tiago": ("tiago_description/robots/tiago.urdf", ("arm_*_joint",)),
    "xarm7": ("xarm_description/urdf/xarm7.urdf", ("joint*",)),
}
FROM = "example-robot-data or robot_descriptions"
Format = Literal["urdf", "dh", "mjcf"]


@dataclass(frozen=True, kw_only=True)
class RobotSource:
    """A description's ``text`` and format, its ``path`` (None where it is built in), and the ``joints`` of the arm.

    ``label`` names it in messages. ``joints`` is None where all joints are the arm's, or nothing is known about them.
    """

    label: str
    text: str
    format: Format
    path: str | None
    joints: tuple[str, ...] | None = None


def find_description(source: str | Path) -> RobotSource:
    """The description of a built-in name, of a file, or of a name in an installed package of descriptions.

    Raises InputError for a name that is none of these, a file that is missing, too large or no text, and a xacro file that
    cannot be expanded.
    """
    name = str(source)
    if name in BUILT_IN:
        file = f"{name}.toml"
        text = resources.files("physident").joinpath("robots", file).read_text(encoding="utf-8")
        return RobotSource(label=file, text=text, format="dh", path=None)
    if os.path.isfile(source):
        return _read(source)
    if re.fullmatch(r"[a-z][a-z0-9_]*", name):
        if (packaged := _packaged(name)) is not None:
            return packaged
        if (described := _described(name)) is not None:
            return described
    names, more = ", ".join(BUILT_IN), ", ".join(PACKAGED)
    near = "" if name in PACKAGED else did_you_mean(name, [*BUILT_IN, *PACKAGED])
    hint = f"; {more}, iiwa14, gen3 and others come with {FROM}: pip install 'physident[robots]'"
    raise InputError(
        f"robot {name!r} not found: expected a .urdf, .xacro, MuJoCo .xml or DH .toml file, or a built-in name ({names}){hint}{near}"
    )


def _read(source: str | Path) -> RobotSource:
    path, label = str(source), Path(source).name
    text = read_text(source, MAX_BYTES, "a URDF, a MuJoCo model or a DH table")
    if label.endswith(".xacro"):
        text = _expanded(path)
    kind: Format = "dh" if label.endswith(".toml") else "mjcf" if _root_tag(text) == "mujoco" else "urdf"
    if kind == "mjcf" and "<!ENTITY" in text:
        raise InputError(f"{label}: declares XML entities, which MuJoCo does not read; expected a file without them")
    return RobotSource(label=label, text=text, format=kind, path=path)


def _root_tag(text: str) -> str | None:
    """The tag of the root element, None where the text does not begin as XML."""
    tags: list[str] = []
    parser = expat.ParserCreate()
    parser.StartElementHandler = lambda tag, _: tags.append(tag)
    for start in range(0, len(text), 4096):
        try:
            parser.Parse(text[start : start + 4096], False)
        except (expat.ExpatError, ValueError):
            return tags[0] if tags else None
        if tags:
            return tags[0]
    return None


def _expanded(path: str) -> str:
    """The URDF text that a xacro file expands to, with the defaults of its arguments."""
    try:
        import xacro  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise InputError(
            f"{path}: a xacro file is expanded by the package xacro, which is not installed; expected pip install 'physident[xacro]', or the URDF that xacro writes"
        ) from None
    said = io.StringIO()
    try:
        with contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
            text = str(xacro.process_file(path).toxml())  # pyright: ignore[reportAttributeAccessIssue]
    except (Exception, SystemExit) as error:  # a xacro file runs expressions: it can fail in any way
        reason = " ".join(f"{error} {said.getvalue()}".split())[:300]
        raise InputError(
            f"{path}: xacro cannot expand this file ({reason}); expected one whose arguments have defaults and whose packages are found here, or the URDF that xacro writes"
        ) from None
    if len(text) > MAX_BYTES:
        raise InputError(f"{path}: expands to {len(text)} characters, expected a URDF of at most {MAX_BYTES}")
    return text


def packaged_meshes() -> Path | None:
    """The folder in which package:// paths of the installed package of descriptions begin; None where it is not installed."""
    try:
        entries = importlib.metadata.files(PACKAGE) or []
    except importlib.metadata.PackageNotFoundError:
        return None
    inside = next((entry for entry in entries if f"share/{PACKAGE}/" in str(entry)), None)
    if inside is None:
        return None
    path = Path(str(inside.locate()))
    return next(folder.parent for folder in path.parents if folder.name == PACKAGE and folder.parent.name == "share")


def _packaged(name: str) -> RobotSource | None:
    """The description of a name in the package of descriptions whose files are installed with it."""
    if name not in PACKAGED:
        return None
    file, joints = PACKAGED[name]
    try:
        entries = importlib.metadata.files(PACKAGE) or []
    except importlib.metadata.PackageNotFoundError:
        return None
    found = next((entry for entry in entries if str(entry).endswith(f"/{file}")), None)
    if found is None:
        return None
    path = str(found.locate())
    text = read_text(path, MAX_BYTES, "a URDF")
    return RobotSource(label=Path(file).name, text=text, format="urdf", path=path, joints=joints)


def _described(name: str) -> RobotSource | None:
    """The description that the package robot_descriptions has by a name; it downloads those that it has not used yet."""
    if importlib.util.find_spec("robot_descriptions") is None:
        return None
    for module in (f"{name}_description", f"{name}_mj_description"):
        if importlib.util.find_spec(f"robot_descriptions.{module}") is None:
            continue
        said = io.StringIO()
        try:
            with contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
                described = importlib.import_module(f"robot_descriptions.{module}")
            path = (
                getattr(described, "URDF_PATH", None) or getattr(described, "MJCF_PATH", None) or described.XACRO_PATH
            )
        except Exception as error:  # git, the network and the package raise errors of many kinds
            reason = " ".join(str(error).split())[:200]
            raise InputError(
                f"robot {name!r}: robot_descriptions cannot provide it ({type(error).__name__}: {reason}); expected a network for its first use, or a file"
            ) from None
        return _read(path)
    return None
