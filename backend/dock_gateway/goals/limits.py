"""The time limits of the parts that follow goals, and how much they remember."""

from dataclasses import dataclass


@dataclass(frozen=True)
class GoalLimits:
    """Limits of one action's goals. Times are in seconds.

    Attributes:
        result_wait: How long an ended goal (by the status topic) waits for its result.
        ask_again_after: Time between two requests for it.
        late_result: How long after such an end a late result is still accepted.
        end_stamp_wait: How long a result waits for the status message of the end, whose timestamp is the same at every
            gateway.
        end_stamps: Maximum number of those times kept.
        patience: How long a running goal is held back while the history does not answer.
        lookup_retry: Time between two lookups then.
        batch_interval: Time between two batches of adopted goals.
        newcomers: Maximum number of goals that wait to be looked up.
        cancel_retry: Time between two cancel requests for the same goal.
        unwanted: Maximum number of unwanted goals, not counting those that are tracked.
        lost: Maximum number of lost goals that are tracked.
        ended: Maximum number of ids of ended goals kept, as an action server may go on reporting them for a while.
        gone_grace: How long a server may be off the graph, as during a restart, before its goals are lost.
        recheck: Time between two checks of a server that is not known to answer, at most: it may just have appeared.
        unanswered_for: How long a server does not answer before another participant is tried: it should be there
            before the outage ends.
        home_after: How long an action is reached through a participant of its own before the common one is tried again.
    """

    result_wait: float = 4.0
    ask_again_after: float = 0.5
    late_result: float = 60.0
    end_stamp_wait: float = 0.2
    end_stamps: int = 2000
    patience: float = 0.5
    lookup_retry: float = 0.1
    batch_interval: float = 0.5
    newcomers: int = 1000
    cancel_retry: float = 1.0
    unwanted: int = 1000
    lost: int = 100
    ended: int = 10_000
    gone_grace: float = 2.0
    recheck: float = 1.0
    unanswered_for: float = 5.0
    home_after: float = 20.0


LIMITS = GoalLimits()
