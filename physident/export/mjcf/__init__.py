"""Export of a model as MJCF, the language of MuJoCo, and into a user's own MJCF. Start with ``mjcf.export_mjcf``."""
