"""The criterion of a design: how much a motion shows of all parameters, or of the difference between two effects.

``information`` accumulates the regressor, ``criterion`` turns it into one number, ``separation`` does the same for two
rival effects. Start with ``criterion``.
"""
