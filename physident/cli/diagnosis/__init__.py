"""Verbs that find and show what a model gets wrong: diagnose, report, view."""
