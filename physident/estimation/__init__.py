"""Estimation: the parameters of a model from recordings, with standard errors.

``identify`` is the verb, ``estimators`` its methods, ``estimate`` the result. ``physical`` holds the convex program for
arms that can exist, ``drive_gains`` the one for motor currents; ``payload`` finds what the arm carries.
"""
