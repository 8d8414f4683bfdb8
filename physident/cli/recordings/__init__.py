"""Verbs that make or look at recordings: inspect, design, simulate, demo."""
