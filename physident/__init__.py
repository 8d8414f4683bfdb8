"""physident: identify the dynamics of robot arms from recordings, and find what their simulation gets wrong.

Names are loaded when they are first used, so that importing the package is quick.
"""

from __future__ import annotations

import inspect
from typing import TYPE_CHECKING, Any

from physident.files import VERSION as __version__

_PUBLIC = {
    "BaseParameters": "identifiability.base_parameters",
    "find_base_parameters": "identifiability.base_parameters",
    "Cone": "effects.classification",
    "Column": "effects.classification",
    "Family": "effects.classification",
    "FormulaEffect": "effects.user.formula",
    "VelocityFriction": "effects.friction",
    "load_effects": "effects.catalogue",
    "Effect": "effects.effect",
    "CATALOGUE": "effects.catalogue",
    "make_effects": "effects.catalogue",
    "diagnose": "diagnosis.diagnose",
    "diagnose_motion": "diagnosis.diagnose",
    "diagnose_at_rest": "diagnosis.at_rest.at_rest",
    "AtRest": "diagnosis.at_rest.poses",
    "Diagnosis": "diagnosis.result.diagnosis",
    "Finding": "diagnosis.result.findings",
    "InputError": "errors",
    "NotSolvedError": "errors",
    "PhysidentError": "errors",
    "PhysidentWarning": "errors",
    "OLS": "estimation.estimators",
    "WLS": "estimation.estimators",
    "Robust": "estimation.estimators",
    "Physical": "estimation.estimators",
    "NoPrior": "estimation.physical.prior",
    "NominalDistance": "estimation.physical.prior",
    "Entropic": "estimation.physical.prior",
    "Bound": "estimation.physical.bounds",
    "Box": "estimation.physical.bounds",
    "Ellipsoid": "estimation.physical.bounds",
    "Estimate": "estimation.estimate",
    "load_estimate": "estimation.estimate_file",
    "DriveGains": "estimation.drive_gains.drive_gains",
    "identify_drive_gains": "estimation.drive_gains.drive_gains",
    "identify": "estimation.identify",
    "Design": "excitation.design",
    "design_trajectory": "excitation.design_trajectory",
    "Discrimination": "excitation.discrimination",
    "design_discriminating": "excitation.design_discriminating",
    "Coverage": "excitation.coverage",
    "design_covering": "excitation.design_covering",
    "Session": "excitation.recording_session",
    "design_session": "excitation.recording_session",
    "Trajectory": "excitation.motion.trajectory",
    "load_trajectory": "excitation.motion.trajectory",
    "random_trajectory": "excitation.motion.trajectory",
    "UrdfExport": "export.urdf",
    "export_urdf": "export.urdf",
    "MjcfExport": "export.mjcf.mjcf",
    "export_mjcf": "export.mjcf.mjcf",
    "patch_mjcf": "export.mjcf.patch",
    "export_c": "export.code",
    "export_casadi": "export.code",
    "export_python": "export.python",
    "export_parameters": "export.parameters",
    "Identifiability": "identifiability.identifiability",
    "measure_identifiability": "identifiability.identifiability",
    "Inspection": "recordings.inspection",
    "inspect_recording": "recordings.inspection",
    "Manipulability": "identifiability.manipulability",
    "measure_manipulability": "identifiability.manipulability",
    "Model": "dynamics.model",
    "Recording": "recordings.recording",
    "load_recording": "recordings.load",
    "load_recordings": "recordings.load",
    "write_report": "report.page",
    "Regressor": "dynamics.regressor",
    "build_regressor": "dynamics.regressor",
    "Payload": "estimation.payload.payload",
    "identify_payload": "estimation.payload.identify_payload",
    "Robot": "robots.robot",
    "load_robot": "robots.load",
    "SetupFinding": "setup_checks.finding",
    "check_setup": "setup_checks.check_setup",
    "Sensors": "simulation.sensors",
    "simulate": "simulation.simulate",
    "Filter": "recordings.signals",
    "Signals": "recordings.signals",
    "prepare": "recordings.preparation",
    "Gain": "validation.scores",
    "Score": "validation.scores",
    "compare": "validation.scores",
    "validate": "validation.scores",
    "view": "graphics.view",
    "draw_prediction": "graphics.figures.draw",
    "draw_recording": "graphics.figures.draw",
    "draw_residual": "graphics.figures.draw",
    "Visibility": "identifiability.visibility",
    "measure_visibility": "identifiability.visibility",
}
__all__ = [*_PUBLIC, "__version__"]

if TYPE_CHECKING:
    from physident.diagnosis.at_rest.at_rest import diagnose_at_rest
    from physident.diagnosis.at_rest.poses import AtRest
    from physident.diagnosis.diagnose import diagnose, diagnose_motion
    from physident.diagnosis.result.diagnosis import Diagnosis
    from physident.diagnosis.result.findings import Finding
    from physident.dynamics.model import Model
    from physident.dynamics.regressor import Regressor, build_regressor
    from physident.effects.catalogue import CATALOGUE, load_effects, make_effects
    from physident.effects.classification import Family
    from physident.effects.effect import Column, Cone, Effect
    from physident.effects.friction import VelocityFriction
    from physident.effects.user.formula import FormulaEffect
    from physident.errors import InputError, NotSolvedError, PhysidentError, PhysidentWarning
    from physident.estimation.drive_gains.drive_gains import DriveGains, identify_drive_gains
    from physident.estimation.estimate import Estimate
    from physident.estimation.estimate_file import load_estimate
    from physident.estimation.estimators import OLS, WLS, Physical, Robust
    from physident.estimation.identify import identify
    from physident.estimation.payload.identify_payload import identify_payload
    from physident.estimation.payload.payload import Payload
    from physident.estimation.physical.bounds import Bound, Box, Ellipsoid
    from physident.estimation.physical.prior import Entropic, NominalDistance, NoPrior
    from physident.excitation.coverage import Coverage
    from physident.excitation.design import Design
    from physident.excitation.design_covering import design_covering
    from physident.excitation.design_discriminating import design_discriminating
    from physident.excitation.design_trajectory import design_trajectory
    from physident.excitation.discrimination import Discrimination
    from physident.excitation.motion.trajectory import Trajectory, load_trajectory, random_trajectory
    from physident.excitation.recording_session import Session, design_session
    from physident.export.code import export_c, export_casadi
    from physident.export.mjcf.mjcf import MjcfExport, export_mjcf
    from physident.export.mjcf.patch import patch_mjcf
    from physident.export.parameters import export_parameters
    from physident.export.python import export_python
    from physident.export.urdf import UrdfExport, export_urdf
    from physident.graphics.figures.draw import draw_prediction, draw_recording, draw_residual
    from physident.graphics.view import view
    from physident.identifiability.base_parameters import BaseParameters, find_base_parameters
    from physident.identifiability.identifiability import Identifiability, measure_identifiability
    from physident.identifiability.manipulability import Manipulability, measure_manipulability
    from physident.identifiability.visibility import Visibility, measure_visibility
    from physident.recordings.inspection import Inspection, inspect_recording
    from physident.recordings.load import load_recording, load_recordings
    from physident.recordings.preparation import prepare
    from physident.recordings.recording import Recording
    from physident.recordings.signals import Filter, Signals
    from physident.report.page import write_report
    from physident.robots.load import load_robot
    from physident.robots.robot import Robot
    from physident.setup_checks.check_setup import check_setup
    from physident.setup_checks.finding import SetupFinding
    from physident.simulation.sensors import Sensors
    from physident.simulation.simulate import simulate
    from physident.validation.scores import Gain, Score, compare, validate


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module 'physident' has no attribute {name!r}")
    from importlib import import_module

    value = getattr(import_module(f"physident.{_PUBLIC[name]}"), name)
    if inspect.isfunction(value):
        from physident.arguments import checked

        value = checked(value)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
