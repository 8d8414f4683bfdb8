"""The search for a motion: a genetic algorithm that starts, and an interior-point method that finishes.

``problem`` states the nonlinear program, ``genetic`` finds starts, ``nlp`` wraps CasADi and IPOPT. Start with ``search``.
"""
