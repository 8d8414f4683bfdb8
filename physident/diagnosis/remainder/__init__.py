"""What a diagnosis leaves unexplained, described: how large it is, what it varies with, when it happens, and what could ever explain it."""
