"""What makes a motion good: the information it carries about parameters, or about the difference of two effects.

``information`` accumulates the regressor, ``criterion`` turns it into one number, ``separation`` and ``rivals`` do the
same for two effects. Start with ``criterion``.
"""
