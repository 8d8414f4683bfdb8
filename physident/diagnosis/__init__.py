"""Diagnosis: which physical effect a model lacks or has wrong, with its proof on left-out data.

``diagnose`` is the verb. It states a ``problem``, runs the ``search``, which has the thresholds and the conditions for
accepting a cause, and returns a ``result``; ``statistics`` has the scores that the search uses. ``at_rest`` handles
recordings without motion. Start with ``diagnose``.
"""
