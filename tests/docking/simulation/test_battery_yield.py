from docking.simulation.battery_yield import BatteryYield


def test_own_messages_do_not_count() -> None:
    courtesy = BatteryYield()
    courtesy.sent(b"ours")
    courtesy.heard(b"ours", 1.0)
    assert not courtesy.others_publish(1.0, 3.0)


def test_it_steps_back_for_others_until_they_have_been_silent() -> None:
    courtesy = BatteryYield()
    courtesy.heard(b"theirs", 1.0)
    assert courtesy.others_publish(1.0, 3.0)
    assert courtesy.others_publish(3.9, 3.0)
    courtesy.heard(b"theirs", 3.9)
    assert courtesy.others_publish(6.8, 3.0)
    assert not courtesy.others_publish(6.9, 3.0)


def test_what_was_ours_long_ago_is_a_recording_that_someone_plays() -> None:
    courtesy = BatteryYield()
    courtesy.sent(b"ours")
    for number in range(100):
        courtesy.sent(b"later %d" % number)
    courtesy.heard(b"ours", 1.0)
    assert courtesy.others_publish(1.0, 3.0)
