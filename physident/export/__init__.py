"""Export of an identified model as URDF, as a table of parameters, or as a Python function.

Each exporter raises an error for, or lists, what its format cannot express. Start with ``urdf.export_urdf``.
"""
