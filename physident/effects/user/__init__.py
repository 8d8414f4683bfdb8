"""Effects that users bring: a law written as a formula, and how classes from a file or another package join the catalogue."""
