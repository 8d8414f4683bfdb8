"""Stability of findings: the search repeated on halves of the recordings' blocks, on products that are stored once."""
