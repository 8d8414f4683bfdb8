"""What a cause means for somebody who runs the robot, and what to do about it: one sentence for each effect."""

from __future__ import annotations

from collections.abc import Sequence

from physident.effects.catalogue import CATALOGUE
from physident.effects.classification import Family

PLAIN = "coulomb_friction"
UNCHANGED = "Nothing that these recordings show has changed on the arm: nothing needs to be done."
UNSETTLED = (
    "No change was found, and these recordings cannot rule one out: record again as listed under “What to record next”."
)
OLD = " What the model lacks, it lacked before: ask what is missing from it, with its own recordings."
WITHOUT_CAUSE = {
    "nothing_missing": "The model is as good as the measurement: nothing needs to be done.",
    "explained": "The model is as good as the measurement: nothing needs to be done.",
    "partly_explained": "The error has a pattern, but no cause is certain: change nothing on the arm for it, and record again as listed under"
    " “What to record next”.",
    "unexplained": "The error has a pattern that no known cause makes: change nothing on the arm for it, record again as listed under"
    " “What to record next”, and inspect the arm if the pattern stays.",
}
EFFECTS = {
    "rigid_body": "The masses in the simulation are not those of this arm: identify the arm again, or correct its description.",
    "rotor_inertia": "The simulation has the motors' own inertia wrong: enter the value below as the joint's armature.",
    "viscous_friction": "Friction that grows with speed is not what the model has: warm up the arm and record again; if it stays, check the"
    " lubricant.",
    "coulomb_friction": "The joint needs another torque to start and keep moving than the model has: warm up and record again; if it stays, check"
    " brake, seals and gear.",
    "friction_asymmetry": "The joint turns more easily in one direction: check the gear's preload and the seals; until then use different friction"
    " for each direction.",
    "stribeck_friction": "The joint sticks more when it creeps: avoid creeping motions, or enter this friction in the controller; check the"
    " lubricant if it is new.",
    "nonlinear_viscous_friction": "Friction over speed is a curve, as grease has it: use the curve in the model; if it is new, check the lubricant.",
    "load_dependent_friction": "The gear rubs harder the more it carries: use this friction in the model; if it has grown since the last"
    " recording, inspect the gear for wear.",
    "presliding_hysteresis": "The joint gives way elastically before it slides: expect errors at reversals; if it is new, check gear and bearing"
    " for play or wear.",
    "warm_up": "Friction falls while the arm warms up: run it for ten minutes before measurements, and do not compare cold with warm recordings.",
    "friction_level": "The friction of all joints is scaled alike, as in an arm that is warmer or colder: compare recordings of equal warmth; if it"
    " stays, use the value in the model.",
    "coupled_friction": "One joint's friction follows the motion of its neighbour, as gears shared by two joints make it: use both in the model;"
    " if it is new, inspect that gear.",
    "torque_constant": "The torque of this joint is scaled: check the drive gain that was given, then the motor (demagnetised or replaced) and its"
    " current sensor.",
    "torque_scale": "The torques of all joints are scaled alike: check the drive gains and the unit of the recordings, and what has changed in the"
    " controller; no single joint is at fault.",
    "torque_crosstalk": "A torque reading shows a share of what other joints carry: calibrate the sensor with load on the other axes, or correct the"
    " readings by the model's shares.",
    "torque_offset": "The torque reading is shifted by a constant: zero the torque or current sensor again.",
    "torque_delay": "The torque reading of this joint lags its motion: look for a filter in its current sensor or an old value that is sent again; if"
    " friction alone lags, it is presliding.",
    "time_delay": "Torque and position are not recorded at the same time: correct the clock of the recording before anything else.",
    "torque_ripple": "Torque waves with the angle, as a gear's teeth, a motor's poles or an offset of its current sensor make it: if it is new, look for a damaged tooth.",
    "joint_spring": "Something pulls the joint back: check cables, hoses and balancing springs.",
    "joint_elasticity": "The joint twists under load: move more gently or damp the vibration; if it is new, check bolts and gear.",
    "payload": "The arm carries a load that the model does not have: weigh the tool, and enter its mass and centre of mass in the controller.",
    "link_inertia": "A link is heavier or lighter than the model says: look for cables, covers or devices that were added to it or removed.",
    "gravity_tilt": "The base is not level, or is mounted at another angle than the model says: check the mount with a spirit level.",
    "gravity_magnitude": "All weights are scaled alike: check the value of gravity in the simulation, then the scale of the torques.",
    "joint_zero_offset": "The joint's zero is not where the model has it: calibrate the joint again.",
    "contact": "The arm touched something at the times below: find out what it was before the recording is used for anything else.",
}
FAMILIES = {
    Family.INERTIA: "The arm's masses differ from the model: look for what was added or removed.",
    Family.FRICTION: "The friction of the joint differs from the model: warm up and record again; if it stays, inspect the gear.",
    Family.TRANSMISSION: "The gear or its surroundings exert a torque that the model does not have: inspect gear, cables and springs.",
    Family.MEASUREMENT: "The measurement differs from the torque: check sensors, gains and clock.",
    Family.MOUNTING: "The arm is mounted or calibrated differently: check base and joint zeros.",
    Family.CONTACT: "Something touched the arm: find out what.",
}
LEARNED = "No known law explains this torque, so its curve was learned: use it in the model, and look at the joint for the reason."

LEARNED_CHANNEL = (
    "The torque reading bends with the torque as no known law has it: check the range of the torque sensor, the motor (saturation) and its drive"
    " gain, and correct the readings by the curve."
)


def practice(effect: str, inseparable: Sequence[str] = ()) -> str:
    """What an effect means and what to do, in one sentence; that of its family where it has none of its own. Where no motion tells friction of
    one kind from plain ``inseparable`` friction, there is no more to do than for the plain one."""
    if CATALOGUE[effect].family is Family.FRICTION and PLAIN in inseparable:
        effect = PLAIN
    learned = LEARNED_CHANNEL if CATALOGUE[effect].acts_on == "measurement" else LEARNED
    return EFFECTS.get(effect) or FAMILIES.get(CATALOGUE[effect].family, learned)
