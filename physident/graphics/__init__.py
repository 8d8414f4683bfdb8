"""Graphics: figures by matplotlib, and sessions for the rerun viewer.

``view`` is the verb behind ``physident.view``. ``figures`` draws one figure a function, ``session`` writes a session,
``scene`` is the arm in 3D, ``style`` the colours of all of them. Start with ``view``.
"""
