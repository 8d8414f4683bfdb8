"""Drive gains: from motor currents to joint torques by means of a load of known mass.

``drive_gains`` is the verb and its result, ``equations`` the linear problem, ``physical_gains`` the same problem over the
physical cones. Start with ``drive_gains.identify_drive_gains``.
"""
