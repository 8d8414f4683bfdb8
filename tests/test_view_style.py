"""Colours of effects: each effect has one, and people tell them apart, colour-blind ones too."""

import itertools

import numpy as np

from physident.effects.catalogue import CATALOGUE, DEFAULT_EFFECTS
from physident.effects.classification import Family
from physident.effects.friction import ViscousFriction
from physident.graphics import style

# what protan and deutan eyes see of linear RGB: Machado, Oliveira and Fernandes (2009), table 1, severity 1
EYES = {
    "normal": np.eye(3),
    "protan": np.array([[0.152, 1.053, -0.205], [0.115, 0.786, 0.099], [-0.004, -0.048, 1.052]]),
    "deutan": np.array([[0.367, 0.861, -0.228], [0.280, 0.673, 0.047], [-0.012, 0.043, 0.969]]),
}


def linear(colour: str) -> np.ndarray:
    c = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def lab(rgb: np.ndarray) -> np.ndarray:
    """CIE L*a*b* under D65."""
    M = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    xyz = M @ np.clip(rgb, 0, 1) / (0.9505, 1.0, 1.089)
    f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def nearest(names: list[str], eye: str) -> float:
    seen = [lab(EYES[eye] @ linear(style.effect_colour(name))) for name in names]
    return min(float(np.linalg.norm(a - b)) for a, b in itertools.combinations(seen, 2))


def test_every_effect_of_the_catalogue_has_a_colour_and_no_other():
    assert set(style.EFFECTS) == set(CATALOGUE)


def test_a_new_effect_has_the_colour_of_its_family(monkeypatch):
    class NewFriction(ViscousFriction):
        name = "new_friction"

    monkeypatch.setitem(CATALOGUE, "new_friction", NewFriction)
    assert style.effect_colour("new_friction") == style.FAMILIES[Family.FRICTION]
    assert set(style.FAMILIES) == set(Family)
    assert all(40 < lab(linear(colour))[0] < 85 for colour in style.FAMILIES.values())


def test_colours_are_told_apart_by_every_eye():
    for eye in EYES:
        assert nearest(list(CATALOGUE), eye) > 10  # two are just noticeably different at 2.3
        assert nearest(list(DEFAULT_EFFECTS), eye) > 25


def test_colours_are_seen_on_black_and_on_white():
    for name in CATALOGUE:
        lightness = lab(linear(style.effect_colour(name)))[0]
        assert 40 < lightness < 85, name
