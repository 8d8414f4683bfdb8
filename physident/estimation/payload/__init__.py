"""The load an arm carries, as ten parameters of the last link.

``payload`` is the result, ``load_regressor`` the columns that a load adds to a regressor. Start with ``identify_payload``.
"""
