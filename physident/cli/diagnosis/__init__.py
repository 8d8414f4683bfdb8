"""Commands that find and show the errors of a model: diagnose, report, view."""
