"""The search for a motion: a genetic algorithm finds starting points, and IPOPT improves the best of them.

``problem`` states the nonlinear program, ``genetic`` finds the starting points, ``ipopt`` calls the solver through CasADi.
Start with ``search``.
"""
