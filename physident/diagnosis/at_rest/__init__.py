"""Diagnosis of recordings without motion: measured torque against gravity and the friction that may hold the arm.

At standstill friction may take any value up to breakaway, so that only torques beyond it contradict a model. Start with
``at_rest.diagnose_at_rest``.
"""
