"""The next session: what a diagnosis has left open, the session that answers it, and what its recordings settled.

Start with ``plan`` and ``resume``.
"""
