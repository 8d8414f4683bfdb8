"""Excitation: motions along which the parameters of a model, or two rival effects, show best.

``design`` and ``discriminate`` are the verbs, ``session`` joins several motions. ``criterion`` is what is made small,
``limits`` what must hold, ``search`` how it is found, ``motion`` the result. Start with ``design``.
"""
