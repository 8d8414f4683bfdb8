"""Estimation: the parameters of a model from recordings, with standard errors.

``identify`` is the verb, ``estimators`` its methods, ``estimate`` the result. ``physical`` is physically consistent
estimation (a semidefinite program), ``drive_gains`` identifies gains from motor currents, ``payload`` the load the arm
carries.
"""
