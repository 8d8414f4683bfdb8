"""Diagnosis: which physical effect a model lacks or has wrong, with its proof on left-out data.

``diagnose`` is the verb. What is ``asked`` becomes a ``problem``; what is ``searched`` by the ``search``, which has the thresholds and
the conditions for accepting a cause, is ``judged`` by ``grading``, and becomes a ``result``; ``statistics`` has the scores that the search
uses. ``at_rest`` handles recordings without motion. Start with ``diagnose``.
"""
