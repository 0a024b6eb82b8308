from small_studies import SPEED, case

from pellucid.studies.members import members_of

MODULUS = "body.block.material.young_modulus"


def digest(settings: dict, until: float | None = None, **base: object) -> str:
    return members_of(case(**base), [settings], until)[0].digest


def test_equal_values_are_one_member() -> None:
    assert digest({MODULUS: "5 kPa"}) == digest({MODULUS: 5000})
    assert len(members_of(case(), [{MODULUS: 5000}, {MODULUS: "5 kPa"}, {MODULUS: 6000}])) == 2


def test_other_settings_cases_and_ends_are_others() -> None:
    assert (
        len({digest({SPEED: 1.5}), digest({SPEED: 1.25}), digest({SPEED: 1.5}, 0.5), digest({SPEED: 1.5}, **{MODULUS: 5e3})})
        == 4
    )


def test_texts_of_a_case_change_no_member() -> None:
    assert digest({SPEED: 1.5}, title="another") == digest({SPEED: 1.5})
