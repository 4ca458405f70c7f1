"""Memory of runs, with the functions that they watch."""

import numpy as np

from freebody.motion.ode.memory import make_log, make_rows, memory, most_events, watch


def test_a_run_watches_functions_of_the_user_and_guarded_ones():
    run, own = memory("dop853", 5, 4)
    constants = np.arange(3.0)
    watch(run.search, 16, constants, (0, 1), (False, True), guarded=2)
    assert own is None and (run.search.guarded, run.search.count) == (2, 4)
    assert run.search.directions.tolist() == [0, 1, -1, -1]
    assert run.search.terminal.tolist() == [0, 1, 1, 1]
    watch(run.search, 16, constants, (0, 1, 0, 0), (True, False, False, False))
    assert run.search.guarded == 0 and run.search.terminal.tolist() == [1, 0, 0, 0]


def test_rows_of_a_piece_follow_each_other():
    """The loop from event to event reads times, lengths and states of a piece from its times on."""
    run, _ = memory("dop853", 5, 4)
    make_rows(run, 7)
    make_log(run.search, 7, run.n)
    at = [part.__array_interface__["data"][0] // 8 for part in (run.times, run.lengths, run.states)]
    assert np.diff(at).tolist() == [8, 8] and run.states.shape == (8, 5)
    assert len(run.search.log_times) == 7 + most_events(4) + 1 == len(run.search.log_states)
