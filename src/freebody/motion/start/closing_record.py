"""Memory of the search for the start of a constrained motion (`gauss_newton`), and of its factors (`sparse_rows`).

Python and the compiled code share it. Nothing in this file needs a compiler.
"""

from __future__ import annotations

from typing import Annotated

from ...native.records import Count, Kernel, Real, Record, Row, Whole, Wholes, record

MET, NOWHERE, FAR, TORN, CROWDED = range(5)
"""How a search ends: a start was found; there is no direction to search in; the coordinates do not converge; the speeds
contradict the conditions; the factors need more room."""


@record
class SparseRows(Record):
    """Rows G, and their factors (G S)ᵀ = H_1 H_2 ... H_r R. All but the first five fields belong to the factors.

    ``starts``, ``columns``    place of the first entry of each row, and columns of the entries
    ``taking_part``, ``free``  1 for each row and column that is not left out
    ``poor``, ``least``        part of a row below which it waits for others, and below which it is dependent

    ``rank``                   number of reflections
    ``rests``, ``dependent``   number of dependent rows, and these
    ``chosen``                 1 for each row that is independent of the rows chosen before
    ``length``                 length of each row
    ``x``, ``z``               the present row by columns, and a vector of the same length
    ``marked``, ``touched``, ``touches``    1 for each column that the present row touches; these columns; their number
    ``met``, ``path``, ``meets``            1 for each reflection that the present row meets; these; their number
    ``first``, ``retired``     first reflection that touches a column, or -1; 1 if the column is a pivot
    ``next``, ``pivot``, ``of_row``         of each reflection: the next of its front, or -1; its pivot; its row
    ``beta``, ``diagonal``     of each reflection: β, and the diagonal of R
    ``starts_v``, ``columns_v``, ``v``, ``filled_v``    entries of the reflections: place of the first one of each,
                               columns, values, and their number in all
    ``starts_r``, ``count_r``, ``rows_r``, ``values``, ``filled_r``    entries of R: place of the first one of each row
                               of G, their number, reflections, values, and their number in all
    ``dense``                  the equations of the dependent rows
    """

    n_rows: Count
    n_columns: Count
    room_of_factors: Count
    starts: Annotated[Wholes, "after_rows"]
    columns: Annotated[Wholes, "n_entries"]
    taking_part: Annotated[Wholes, "n_rows"]
    free: Annotated[Wholes, "n_columns"]
    poor: Real
    least: Real
    rank: Whole
    filled_v: Whole
    filled_r: Whole
    rests: Whole
    touches: Whole
    meets: Whole
    chosen: Annotated[Wholes, "n_rows"]
    starts_r: Annotated[Wholes, "n_rows"]
    count_r: Annotated[Wholes, "n_rows"]
    dependent: Annotated[Wholes, "n_rows"]
    length: Annotated[Row, "n_rows"]
    first: Annotated[Wholes, "n_columns"]
    retired: Annotated[Wholes, "n_columns"]
    marked: Annotated[Wholes, "n_columns"]
    touched: Annotated[Wholes, "n_columns"]
    path: Annotated[Wholes, "n_columns"]
    x: Annotated[Row, "n_columns"]
    z: Annotated[Row, "n_columns"]
    met: Annotated[Wholes, "after_columns"]
    next: Annotated[Wholes, "after_columns"]
    pivot: Annotated[Wholes, "after_columns"]
    of_row: Annotated[Wholes, "after_columns"]
    starts_v: Annotated[Wholes, "after_columns"]
    beta: Annotated[Row, "after_columns"]
    diagonal: Annotated[Row, "after_columns"]
    columns_v: Annotated[Wholes, "room_of_factors"]
    v: Annotated[Row, "room_of_factors"]
    rows_r: Annotated[Wholes, "room_of_factors"]
    values: Annotated[Row, "room_of_factors"]
    dense: Annotated[Row, "room_of_factors"]


@record
class Closing(Record):
    """A search for a state (q, u) on the conditions.

    ``conditions``, ``motion``, ``moved``, ``least``    kernels of (q, u, selection): (φ, G); (ψ, G, diagonal of M,
                      pivots of M); q'; δ of the speeds
    ``c``             constants of the kernels

    Written by the caller:

    ``t``, ``state``  time, then coordinates and speeds; the selection of the kernel ``least`` stands after them
    ``on_speeds``     1 for each condition that restricts speeds only
    ``immobile``, ``fixed``    1 for each speed along which no coordinate may move, and for each that keeps its value
    ``quaternions``   coordinates at which unit quaternions begin
    ``most_steps``    maximum number of steps
    ``near``          acceptable residual of the coordinates
    ``dependent``, ``poor``, ``light``    tolerance for dependent rows and columns; part of a row that is small; part of
                      a mass below which it may be zero

    Read by the caller:

    ``status``        how the search ended
    ``worst``, ``missed``, ``scale``    the condition on speeds with the largest residual, the residual, and its scale
    ``heavy``         1 if all speeds certainly move masses
    ``independent``   1 for each condition that is independent

    The rest is memory: outputs of the kernels, δ, q', and the speeds at the beginning.
    """

    conditions: Kernel
    motion: Kernel
    moved: Kernel
    least: Kernel
    c: Row
    n_coordinates: Count
    n_speeds: Count
    n_conditions: Count
    n_quaternions: Count
    n_entries: Count
    t: Real
    near: Real
    dependent: Real
    poor: Real
    light: Real
    missed: Real
    scale: Real
    most_steps: Whole
    status: Whole
    worst: Whole
    heavy: Whole
    state: Annotated[Row, "n_selected"]
    on_speeds: Annotated[Wholes, "n_conditions"]
    independent: Annotated[Wholes, "n_conditions"]
    immobile: Annotated[Wholes, "n_speeds"]
    fixed: Annotated[Wholes, "n_speeds"]
    quaternions: Annotated[Wholes, "n_quaternions"]
    outputs: Annotated[Row, "n_outputs_of_conditions"]
    change: Annotated[Row, "n_speeds"]
    unit: Annotated[Row, "n_speeds"]
    rates: Annotated[Row, "n_coordinates"]
    before: Annotated[Row, "n_speeds"]
    rows: SparseRows


def sizes_of_rows(m: int, n: int, entries: int, room: int) -> dict[str, int]:
    """Return the sizes of the rows of `SparseRows`: m rows and n columns with room for factors."""
    return {
        "n_rows": m, "n_columns": n, "room_of_factors": room, "n_entries": entries, "after_rows": m + 1,
        "after_columns": n + 2,
    }  # fmt: skip


def sizes_of_closing(n_q: int, n: int, m: int, quaternions: int, entries: int, room: int) -> dict[str, int]:
    """Return the sizes of the rows of `Closing`: m conditions on n_q coordinates and n speeds."""
    return {
        **sizes_of_rows(m, n, entries, room), "n_coordinates": n_q, "n_speeds": n, "n_conditions": m,
        "n_quaternions": quaternions, "n_selected": n_q + 2 * n + m, "n_outputs_of_conditions": m + entries + 2 * n,
    }  # fmt: skip
