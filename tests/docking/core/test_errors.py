from docking.core import errors as failures
from docking.core.errors import DockingError, ErrorCode


def test_every_code_has_a_number_of_its_own() -> None:
    numbers = [code.number for code in ErrorCode]
    assert len(set(numbers)) == len(numbers)


def test_the_numbers_are_nav2s_where_it_has_them() -> None:
    known = {"FAILED_TO_STAGE": 903, "FAILED_TO_DETECT_DOCK": 904, "FAILED_TO_CONTROL": 905, "FAILED_TO_CHARGE": 906}
    known |= {"NONE": 0, "DOCK_NOT_IN_DB": 901, "DOCK_NOT_VALID": 902, "TIMEOUT": 907, "UNKNOWN": 999}
    assert {name: ErrorCode(name).number for name in known} == known


def test_every_exception_has_a_code_of_its_own_and_its_name() -> None:
    errors = [each for each in vars(failures).values() if isinstance(each, type) and DockingError in each.__bases__]
    assert len(errors) == 16
    for error in errors:
        assert error.error_code.value.replace("_", "").lower() == error.__name__.lower()
