from robot_io.reception import received_at


def test_a_message_that_waited_is_as_old_as_it_is() -> None:
    assert received_at(now=100.0, wall_now=5000.0, received_wall=4993.0) == 93.0


def test_a_wall_clock_that_was_set_back_makes_nothing_younger_than_now() -> None:
    assert received_at(now=100.0, wall_now=5000.0, received_wall=6000.0) == 100.0


def test_without_a_reception_time_a_message_came_now() -> None:
    assert received_at(now=100.0, wall_now=5000.0, received_wall=0.0) == 100.0
