"""Replay: the arm of a model is simulated from measured states, and compared with what the real arm did.

``windows`` cuts recordings into the stretches that are simulated, ``arm`` has the model's equations of motion for many
states at once, ``own_simulator`` and ``mujoco_simulator`` solve them, ``replay`` measures the errors. Start with
``replay.replay``.
"""
