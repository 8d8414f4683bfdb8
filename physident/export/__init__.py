"""Export of an identified model as URDF, MJCF, a table of parameters, a Python function, C code or a CasADi function.

Each exporter raises an error for, or lists, what its format cannot express. Start with ``formats.export_files``.
"""
