"""Verbs on the recordings of many arms: ``fleet`` and ``drift``."""
