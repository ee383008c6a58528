import pytest

from checks.handbook.fits import clearances_of


@pytest.mark.parametrize(
    ("code", "diameter", "least", "largest"),
    [
        ("H7/g6", 25, 7, 41),  # the package pressfit's own example
        ("H7/h6", 30, 0, 34),  # a diameter belongs to the step that it ends
        ("H7/h6", 30.001, 0, 41),
        ("F8/h6", 44, 25, 80),  # the pin's tolerance with the bore's deviation
        ("F8/f7", 44, 50, 114),
        ("H11/d9", 500, 230, 785),
        ("H5/h5", 1, 0, 8),
    ],
)
def test_clearance_is_that_of_the_tables(code, diameter, least, largest):
    assert clearances_of(code, diameter) == (least / 1000, largest / 1000)


@pytest.mark.parametrize(
    ("code", "diameter", "words"),
    [
        ("H7-f7", 44, "reads bore/pin"),
        ("f7/H7", 44, "reads bore/pin"),
        ("H7/p6", 44, "state the clearance itself"),
        ("H4/h4", 44, "from 5 to 11, not 4"),
        ("H7/f7", 501, "up to 500 mm"),
    ],
)
def test_a_fit_that_the_tables_do_not_hold_is_refused(code, diameter, words):
    with pytest.raises(ValueError, match=words):
        clearances_of(code, diameter)
