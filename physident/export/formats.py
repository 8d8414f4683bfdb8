"""The files of one export: every text is complete before the first is written."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.export.code import c_of, export_casadi
from physident.export.held import Held, of_one_instant
from physident.export.mjcf.callback import callback_of, with_callback
from physident.export.mjcf.mjcf import mjcf_of
from physident.export.mjcf.patch import patch_mjcf
from physident.export.parameters import parameters_of
from physident.export.python import python_of
from physident.export.urdf import urdf_of
from physident.files import json_text, write_text
from physident.outputs import together


@dataclass(frozen=True, kw_only=True)
class Targets:
    """Where each format goes, None for those that are not wanted; ``patch`` is a user's MJCF and ``meshes`` the folder that
    package:// stands for in the robot's URDF."""

    urdf: Path | None = None
    mjcf: Path | None = None
    patch: Path | None = None
    callback: Path | None = None
    json: Path | None = None
    python: Path | None = None
    c: Path | None = None
    casadi: Path | None = None
    meshes: Path | None = None

    @property
    def written(self) -> tuple[Path, ...]:
        """The files that are written, in the order of the options."""
        patched = self.mjcf or self.patch
        files = (self.urdf, patched, self.callback, self.json, self.python, self.c, self.casadi)
        return tuple(path for path in files if path is not None)


@dataclass(frozen=True, eq=False)
class Exported:
    """What was written: ``text`` for people, and by format the part of the model that a simulator's file holds."""

    text: str
    held: dict[str, Held]


def export_files(estimate: Estimate, to: Targets) -> Exported:
    """Write a model in every wanted format; raises InputError, and writes nothing, where one of them cannot be."""
    if not to.written:
        raise InputError(
            "nothing to write, expected --urdf, --mjcf, --patch, --json, --python, --c or --casadi with a file"
        )
    if to.callback is not None and to.mjcf is None and to.patch is None:
        raise InputError("--callback has what an MJCF file does not hold; expected it beside --mjcf or --patch")
    model = estimate.model
    texts: dict[Path, str] = {}
    shown: list[str] = []
    held: dict[str, Held] = {}
    if to.urdf is not None:
        urdf = urdf_of(model)
        texts[to.urdf], held["URDF"] = urdf.text, urdf.held
        shown.append(repr(urdf))
    if to.json is not None:
        texts[to.json] = json_text(parameters_of(estimate))
    timely, late = of_one_instant(model)
    functions = [path for path in (to.python, to.c, to.casadi) if path is not None]
    if to.python is not None:
        texts[to.python] = python_of(timely)
    if to.c is not None:
        texts[to.c] = c_of(timely)
    if functions and late:
        shown.append(f"not in {', '.join(map(str, functions))}, whose torque is that of one instant: {'; '.join(late)}")
    mjcf = None
    if to.mjcf is not None or to.patch is not None:
        mjcf = mjcf_of(model, (to.mjcf or Path()).parent, to.meshes)
        callback = callback_of(model, mjcf.held) if to.callback is not None else None
        held["MJCF" if callback is None else "MJCF with its callback"] = (
            mjcf.held if callback is None else with_callback(mjcf.held)
        )
        if to.callback is not None and callback is None:
            raise InputError(
                "MJCF holds every effect of this model's arm, so there is no callback; leave --callback out"
            )
        if to.callback is not None and callback is not None:
            texts[to.callback] = callback
    with together():
        if to.patch is not None:
            mjcf = patch_mjcf(model, to.patch, to.mjcf)
        elif to.mjcf is not None and mjcf is not None:
            texts[to.mjcf] = mjcf.text
        for path, text in texts.items():
            write_text(path, text)
        if to.casadi is not None:
            export_casadi(timely, to.casadi)
    if mjcf is not None:
        shown.append(repr(mjcf))
        if mjcf.held.left_out and to.callback is None:
            shown.append(
                "what MJCF does not hold comes with --callback FILE as a Python callback, and with --json as numbers"
            )
    return Exported("\n".join([*shown, f"written: {', '.join(map(str, to.written))}"]), held)
