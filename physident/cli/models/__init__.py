"""Verbs that make, judge or hand on a model: identify, validate, compare, payload, drive-gains, base-parameters, export."""
