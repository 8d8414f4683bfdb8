"""The search of a diagnosis: candidates are added one at a time while they beat chance, then each is tried for removal.

``candidate_scores`` scores every candidate beside a ``hypothesis``, ``left_out_costs`` say what it is worth,
``acceptance`` decides which candidate is accepted, ``contact_scan`` and ``contact_refinement`` find contacts, ``turning_speeds``
searches again where friction turns otherwise beside what was found. Start with ``forward_search``.
"""
