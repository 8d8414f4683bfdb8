"""Diagnosis: which physical effect a model lacks or has wrong, with its proof on left-out data.

``diagnose`` is the verb. It states a ``problem``, runs the ``search``, whose thresholds come from ``statistics``, and
returns a ``result``; ``at_rest`` answers for recordings without motion. Start with ``diagnose``.
"""
