"""The search of a diagnosis: candidates are added one at a time while they beat chance, then each is tried for removal.

``candidate_scores`` scores every candidate beside a ``hypothesis``, ``acceptance`` decides which one is taken, ``contact``
looks for pushes, ``rivals`` for effects that data cannot tell apart. Start with ``forward_search``.
"""
