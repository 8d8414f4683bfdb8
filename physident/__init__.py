"""physident: identify the dynamics of robot arms from recordings, and find what their simulation gets wrong.

Names are loaded when they are first used, so that importing the package is quick.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

_PUBLIC = {
    "BaseParameters": "base_parameters",
    "find_base_parameters": "base_parameters",
    "Cone": "effects.effect",
    "Column": "effects.effect",
    "Effect": "effects.effect",
    "CATALOGUE": "effects.catalogue",
    "make_effects": "effects.catalogue",
    "diagnose": "diagnosis.diagnose",
    "diagnose_at_rest": "diagnosis.at_rest",
    "AtRest": "diagnosis.poses",
    "Diagnosis": "diagnosis.findings",
    "Finding": "diagnosis.findings",
    "InputError": "errors",
    "NotSolvedError": "errors",
    "PhysidentError": "errors",
    "PhysidentWarning": "errors",
    "OLS": "estimation.estimators",
    "WLS": "estimation.estimators",
    "Robust": "estimation.estimators",
    "Physical": "estimation.estimators",
    "NoPrior": "estimation.prior",
    "NominalDistance": "estimation.prior",
    "Entropic": "estimation.prior",
    "Bound": "estimation.knowledge",
    "Box": "estimation.knowledge",
    "Ellipsoid": "estimation.knowledge",
    "Estimate": "estimation.estimate",
    "load_estimate": "estimation.estimate",
    "DriveGains": "estimation.drive_gains",
    "identify_drive_gains": "estimation.drive_gains",
    "identify": "estimation.identify",
    "Design": "excitation.design",
    "design_trajectory": "excitation.design",
    "Discrimination": "excitation.discriminate",
    "design_discriminating": "excitation.discriminate",
    "Session": "excitation.session",
    "design_session": "excitation.session",
    "Trajectory": "excitation.trajectory",
    "load_trajectory": "excitation.trajectory",
    "random_trajectory": "excitation.trajectory",
    "UrdfExport": "export.urdf",
    "export_urdf": "export.urdf",
    "export_python": "export.python",
    "export_parameters": "export.parameters",
    "Identifiability": "identifiability",
    "measure_identifiability": "identifiability",
    "Inspection": "inspection",
    "inspect_recording": "inspection",
    "Manipulability": "manipulability",
    "measure_manipulability": "manipulability",
    "Model": "model",
    "Recording": "recording",
    "load_recording": "recording",
    "load_recordings": "recording",
    "write_report": "report.page",
    "Regressor": "regressor",
    "build_regressor": "regressor",
    "Payload": "payload",
    "identify_payload": "payload",
    "Robot": "robot",
    "load_robot": "robot",
    "Sensors": "simulation.sensors",
    "simulate": "simulation.simulate",
    "Filter": "signals",
    "Signals": "signals",
    "prepare": "signals",
    "Gain": "validation",
    "Score": "validation",
    "compare": "validation",
    "validate": "validation",
    "view": "view",
    "Visibility": "visibility",
    "measure_visibility": "visibility",
}
__all__ = [*_PUBLIC, "__version__"]

if TYPE_CHECKING:
    from physident.base_parameters import BaseParameters, find_base_parameters
    from physident.diagnosis.at_rest import diagnose_at_rest
    from physident.diagnosis.diagnose import diagnose
    from physident.diagnosis.findings import Diagnosis, Finding
    from physident.diagnosis.poses import AtRest
    from physident.effects.catalogue import CATALOGUE, make_effects
    from physident.effects.effect import Column, Cone, Effect
    from physident.errors import InputError, NotSolvedError, PhysidentError, PhysidentWarning
    from physident.estimation.drive_gains import DriveGains, identify_drive_gains
    from physident.estimation.estimate import Estimate, load_estimate
    from physident.estimation.estimators import OLS, WLS, Physical, Robust
    from physident.estimation.identify import identify
    from physident.estimation.knowledge import Bound, Box, Ellipsoid
    from physident.estimation.prior import Entropic, NominalDistance, NoPrior
    from physident.excitation.design import Design, design_trajectory
    from physident.excitation.discriminate import Discrimination, design_discriminating
    from physident.excitation.session import Session, design_session
    from physident.excitation.trajectory import Trajectory, load_trajectory, random_trajectory
    from physident.export.parameters import export_parameters
    from physident.export.python import export_python
    from physident.export.urdf import UrdfExport, export_urdf
    from physident.identifiability import Identifiability, measure_identifiability
    from physident.inspection import Inspection, inspect_recording
    from physident.manipulability import Manipulability, measure_manipulability
    from physident.model import Model
    from physident.payload import Payload, identify_payload
    from physident.recording import Recording, load_recording, load_recordings
    from physident.regressor import Regressor, build_regressor
    from physident.report.page import write_report
    from physident.robot import Robot, load_robot
    from physident.signals import Filter, Signals, prepare
    from physident.simulation.sensors import Sensors
    from physident.simulation.simulate import simulate
    from physident.validation import Gain, Score, compare, validate
    from physident.view.session import view
    from physident.visibility import Visibility, measure_visibility


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module 'physident' has no attribute {name!r}")
    from importlib import import_module

    value = getattr(import_module(f"physident.{_PUBLIC[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
