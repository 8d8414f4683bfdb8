"""A session for the rerun viewer: the arm in motion, torques, residuals, effects, a diagnosis and a designed motion.

``write`` writes the file from its ``content``; ``blueprint`` is the layout, and the other modules log one part each. Start
with ``write``.
"""
