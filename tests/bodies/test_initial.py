"""Initial fields of bodies."""

from collections.abc import Iterator
from typing import ClassVar, Literal

import numpy as np
import pytest
from pydantic import ValidationError
from registries import forgotten_afterwards
from small_cases import RATE_SOLID, SOLID, box, case

from pellucid.bodies.initial import InitialField, Polynomial, SineWave, SphericalHarmonic, VelocityGradient
from pellucid.registry import register

WAVE = {"amplitude": (0.0, 0.1, 0.0), "wave_vector": (2.0, 0.0, 0.0), "phase": 0.5}


@pytest.fixture(autouse=True)
def _nothing_stays() -> Iterator[None]:
    with forgotten_afterwards():
        yield


def block(material=SOLID, **more):
    return case(box((1, 1, 1), (3, 3, 3), material, **more)).body[0]


def test_velocities_add_up():
    body = block(velocity=(1, 0, 0), angular_velocity=(0, 0, 2), velocity_wave=WAVE, initial=[{"kind": "sine-wave", **WAVE}])
    position = np.array([[2.0, 2.0, 2.0], [3.0, 2.0, 1.0]])
    wave = SineWave(**WAVE).at(position)
    assert np.allclose(wave[:, 1], 0.1 * np.sin([4.5, 6.5]))
    assert np.allclose(body.initial_velocity(position), [[1, 0, 0], [1, 2, 0]] + 2 * wave, rtol=1e-14)


def test_a_membrane_has_initial_fields_too():
    rectangle = {"corner": (1, 1, 2), "first_edge": (2, 0, 0), "second_edge": (0, 2, 0), "points": (9, 9)}
    material = {"kind": "linear-membrane", "density": 1.0, "young_modulus": 1.0, "poisson_ratio": 0.3}
    table = {"name": "net", "surface": {"rectangle": rectangle}, "thickness": 0.1, "material": material, "velocity": (0, 0, 1)}
    for kind in ("membrane-points", "membrane-elements"):
        body = case(table | {"kind": kind, "initial": [{"kind": "sine-wave", **WAVE}]}).body[0]
        position = np.array([[1.0, 2.0, 2.0]])
        assert np.allclose(body.initial_velocity(position), np.array([0, 0, 1]) + SineWave(**WAVE).at(position))


def test_a_state_of_the_material_can_be_set_and_no_other():
    @register
    class Pressed(InitialField):
        quantity: ClassVar[str] = "stress"
        kind: Literal["pressed"] = "pressed"

        def at(self, position: np.ndarray) -> np.ndarray:
            return np.outer(-position[:, 2], [1.0, 1.0, 1.0, 0.0, 0.0, 0.0])

    @register
    class Torn(InitialField):
        quantity: ClassVar[str] = "damage"
        kind: Literal["torn"] = "torn"

        def at(self, position: np.ndarray) -> np.ndarray:
            return np.ones(len(position))

    body = block(RATE_SOLID, initial=[{"kind": "pressed"}])
    position = np.array([[1.0, 1.0, 3.0]])
    arrays = {"position": position, "stress": np.zeros((1, 6))}
    body.add_initial_state(arrays)
    assert arrays["stress"].tolist() == [[-3.0, -3.0, -3.0, 0.0, 0.0, 0.0]]
    assert not body.initial_velocity(position).any()
    with pytest.raises(ValidationError, match='kind "torn" sets `damage`, but the points of this body do not have it'):
        block(RATE_SOLID, initial=[{"kind": "torn"}])


def test_spherical_harmonics_are_orthonormal():
    """Over the nodes of Gauss's rule in z and equal angles, which integrate products of degree 8 exactly."""
    z, weight = np.polynomial.legendre.leggauss(8)
    angle = 2.0 * np.pi * np.arange(12) / 12
    across = np.sqrt(1.0 - z**2)[:, None]
    places = np.stack([across * np.cos(angle), across * np.sin(angle), np.broadcast_to(z[:, None], (8, 12))], axis=-1)
    orders = [(degree, order) for degree in range(5) for order in range(-degree, degree + 1)]
    centre = (1.0, -2.0, 0.5)
    values = [
        SphericalHarmonic(degree=degree, order=order, centre=centre).at(3.0 * places.reshape(-1, 3) + centre)
        for degree, order in orders
    ]
    products = np.einsum("ap,bp,p->ab", values, values, np.repeat(weight, 12) * np.pi / 6.0)
    assert products == pytest.approx(np.eye(25), abs=1e-13)
    pole = SphericalHarmonic(degree=1, amplitude=2.0).at(np.array([[0.0, 0.0, 5.0]]))
    assert pole == pytest.approx(2.0 * np.sqrt(0.75 / np.pi), rel=1e-14)


def test_a_polynomial_vanishes_at_its_zeros():
    field = Polynomial(factor=2.0, zeros=(1.0, -1.0), axis="y")
    assert field.at(np.array([[9.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 3.0, 0.0]])).tolist() == [0.0, 0.0, 16.0]
    assert Polynomial(factor=0.5).at(np.zeros((2, 3))).tolist() == [0.5, 0.5]


def test_a_concentration_is_no_matter_of_bodies_that_move():
    text = 'kind "polynomial" sets `concentration`, but the points of this body do not have it'
    with pytest.raises(ValidationError, match=text):
        block(initial=[{"kind": "polynomial"}])


def test_a_velocity_that_varies_linearly():
    field = VelocityGradient(x=(0.0, 2.0, 0.0), z=(1.0, 0.0, -3.0), origin=(1.0, 0.0, 0.0))
    assert np.allclose(field.at(np.array([[1.0, 0.0, 0.0], [2.0, 4.0, 5.0]])), [[0.0, 0.0, 0.0], [8.0, 0.0, -14.0]])


FLAT, TURNS = "but the grid is one cell thick along z", "bodies rotate about z only"


@pytest.mark.parametrize(
    ("body", "words"),
    [
        (
            {"angular_velocity": (1, 0, 0)},
            ["angular_velocity: the angular velocity has the component 1 rad/s about x", FLAT, TURNS],
        ),
        ({"angular_velocity": (0, -2, 1), "rigid": True}, ["has the component -2 rad/s about y", TURNS]),
        ({"velocity": (1, 0, 3)}, ["velocity: the velocity has the component 3 m/s along z", FLAT, "nothing moves"]),
        ({"velocity_wave": {"amplitude": (0, 0, 1), "wave_vector": (1, 0, 0)}}, ["velocity_wave: gives the body a velocity"]),
        ({"initial": [{"kind": "velocity-gradient", "z": (0, 1, 0)}]}, ["initial.0: gives the body a velocity along z", FLAT]),
    ],
)
def test_motions_out_of_a_plane_are_refused(body, words):
    with pytest.raises(ValidationError) as error:
        case(box((1, 1, 0), (3, 3, 0), per_cell=(2, 2, 1), **body), counts=(4, 4, 0))
    for text in words:
        assert text in str(error.value)
    case(box((1, 1, 1), (3, 3, 3), **body))


def test_nothing_turns_on_a_line():
    with pytest.raises(ValidationError, match="about z, but the grid is one cell thick along y, z: nothing rotates"):
        case(box((1, 0, 0), (3, 0, 0), per_cell=(2, 1, 1), angular_velocity=(0, 0, 1)), counts=(4, 0, 0))


def test_motions_in_a_plane_are_not():
    body = {"angular_velocity": (0, 0, 1), "velocity": (1, 1, 0), "initial": [{"kind": "velocity-gradient", "x": (0, 1, 0)}]}
    case(box((1, 1, 0), (3, 3, 0), per_cell=(2, 2, 1), **body), counts=(4, 4, 0))
    case(box((0, 1, 1), (0, 3, 3), per_cell=(1, 2, 2), angular_velocity=(1, 0, 0)), counts=(0, 4, 4))
