"""Motions that were recorded twice: what a model lacks is in both recordings, so their difference shows a change alone. Start with ``comparison``."""
