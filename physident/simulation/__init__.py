"""Simulation: a robot with the effects of its model, tracked by a controller and read by sensors.

``plant`` has the equations of motion, ``integrate`` and ``radau`` solve them, ``controllers`` follow a motion, ``sensors``
make recordings. Start with ``simulate``.
"""
