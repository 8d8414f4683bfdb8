"""A session for the rerun viewer: the arm in motion, torques, residuals, effects, a diagnosis, a design.

``session.view`` writes it; ``content`` is what is shown, ``blueprint`` the layout, the other files log one panel each.
"""
