"""Export: an identified model for others to use, as a URDF, a table of parameters or a Python function.

Each exporter refuses what its target cannot express. Start with ``urdf.export_urdf``.
"""
