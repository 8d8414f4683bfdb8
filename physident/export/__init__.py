"""An identified model for others to use: a URDF, a table of parameters, a Python function."""

from physident.export.parameters import export_parameters
from physident.export.python import export_python
from physident.export.urdf import UrdfExport, export_urdf, urdf_of

__all__ = ["UrdfExport", "export_parameters", "export_python", "export_urdf", "urdf_of"]
