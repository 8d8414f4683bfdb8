"""Excitation: motions that show the parameters of a model, or the difference between two rival effects, best.

``design_trajectory`` and ``design_discriminating`` design a motion, and ``recording_session`` combines several. The
``criterion`` is minimised within the ``limits`` by the ``search``; the result is a ``motion``. Start with
``design_trajectory``.
"""
