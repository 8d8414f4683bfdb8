"""physident: identify the dynamics of robot arms from recordings, and find what their simulation gets wrong."""
