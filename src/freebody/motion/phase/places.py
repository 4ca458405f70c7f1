"""Places of the memory of a phase, as `closed_contacts` reads it and `candidates` writes it.

The constants c that a kernel of a phase gets are one block of real numbers: the address of a table of integers, the
constants of the kernels that it calls, then working memory. The table has these numbers first, and lists behind them;
places of lists are places of the table, places of numbers are places of c.
"""

from __future__ import annotations

(
    N_Q,  # coordinates
    N_U,  # speeds
    CONTACTS,  # candidate contacts
    ROWS,  # their rows: normal and tangents of each
    OWN,  # active conditions of the machine itself
    ALL_OWN,  # all conditions of the machine itself
    CONDITIONS,  # conditions of this phase, its own first
    ACTIVE,  # independent ones among them
    SLIPPING,  # 1 if a contact slips with friction
    ENDINGS,  # functions that may end the phase
    EXPRESSIONS,  # functions of the user before them
    MACHINE,  # address of the kernel "machine"
    TOUCHES,  # list: addresses of the kernels of the contacts
    PAIR_COUNT,  # pairs of bodies with contacts
    PAIRS,  # list: addresses of the kernels of the gaps and reaches between the bodies of each pair
    PAIR_AT,  # list: places of their outputs
    CONSTANTS,  # place of the constants of these kernels
    VALUES,  # address of the kernel of the user's functions
    VALUES_CONSTANTS,
    POWER,  # address of the kernel of drives and moving conditions, 0 if there are none
    POWER_CONSTANTS,
    DERIVED,  # address of a kernel of the state, accelerations, forces and multipliers
    DERIVED_CONSTANTS,
    CALLED,  # list: number of the closed contacts, then these contacts
    WATCHED,  # list: number of the open contacts, then these contacts
    CONTACT,  # list: six numbers for each contact
    KIND,  # list: four more numbers for each contact
    ROW,  # list: three numbers for each row
    COLUMNS,  # list: place in the order of elimination of each entry of the rows
    ORDER,  # list: speed at each place of the order of elimination
    STARTS,  # list: first entry of each column of L, and the end
    PLACES,  # list: row of each entry of L
    INDEPENDENT,  # list: active conditions
    HOLONOMIC,  # list: number of the active conditions that restrict coordinates, then these conditions
    OWN_NUMBER,  # list: number of each active condition of the machine among all
    OWN_HOLONOMIC,  # list: 1 for each of these that restricts coordinates
    CONDITION,  # list: five numbers for each condition
    ENDING,  # list: four numbers for each ending
    MACHINE_AT,  # outputs of "machine", these six: q'
    FREE_AT,  # D^-½ L⁻¹ f
    SCALE_AT,  # D^-½
    L_AT,
    LOAD_AT,  # power of loads
    OWN_AT,  # for each condition: residual, rate, γ, then its row
    Y_AT,  # row D^-½ L⁻¹ Gᵀ of each condition
    K_AT,  # rows D^-½ L⁻¹ Kᵀ of slipping contacts
    RIGHT_AT,  # numbers for each condition
    LAMBDA_AT,
    WEIGHT_AT,
    SQUARE_AT,  # a matrix of active conditions, a right-hand side, a copy of the matrix
    G_AT,  # a matrix of active and all conditions
    STEP_AT,  # numbers for each speed
    SPARE_AT,
    BAND_AT,  # for each contact, the gap at which it closes: 0, or the gap at the start if that is negative
    DIRECTION_AT,  # two components for each contact, of fixed directions
    STATE_AT,  # state, accelerations, contact forces, multipliers: one after another
    UDOT_AT,
    FORCE_AT,
    MULTIPLIER_AT,
    HELD_COUNT,  # contacts that a normal force of 1 holds
    HEAD,
) = range(61)

SEEN_AT, AT, TANGENTS, REACHES, FIRST, AWAY_AT = range(6)
"""Numbers of a contact: place of its gap and reaches among those of its pair, place of its own outputs (gap, reaches,
μ, μ_s, e, μ at rest, rates, biases), tangents, reaches, first row, place of the rates of its reaches."""
CONTACT_SIZE, ROW_SIZE, KIND_SIZE = 6, 3, 4
ROUGH, SIDE_OF, HELD, PUSHED = range(4)
"""More numbers of a contact: 1 if it may have friction, the side that it ends or -1, 1 if a normal force of 1 holds it
(its normal is no condition), and the direction in which it then slips or `NO_SLIP`."""
SOURCE, ROW_OF, SLIP, NORMAL_OF, FORCE_ROW = range(5)
"""Numbers of a condition: contact (or -1 - place of the machine's condition), row of the contact, direction of slip,
condition of the normal of a tangent or -1, place of its row of K."""
CONDITION_SIZE = 5
NO_SLIP, ALONG, PLUS, MINUS, FIXED = range(5)
"""Directions of slip: none or without friction, along the slip velocity, along the tangent, against it, or fixed: a
contact at rest at its limit of friction."""
LAW, CONTACT_OF, SIGN, PLACE = range(4)
"""Numbers of an ending."""
ENDING_SIZE = 4
GAP, NORMAL, CONE, LINE_CONE, STOP, LINE_STOP, REACH, SIDE, NEVER = range(9)
"""Laws of endings. The place of a reach is its number, of other laws -1."""
OPEN, STICK, SLIDE_ON, SLIDE_BACK, SLIDE, SMOOTH, LIMIT = range(7)
"""Modes of a contact: open, stick, slip along its only tangent or against it, slip, slip without friction in this run,
and at rest at its limit of friction."""

ROUNDED = 2.0**-44
"""Round-off of a contact force relative to the sum of its parts: 256 units in the last place.

A sum of n parts, or the solution of n equations by elimination, has an error of n units in the last place of Σ|parts|
(Higham, Accuracy and Stability, 2002, chapters 4 and 10). The value therefore suits machines of up to some hundred
speeds and closed contacts. Contacts with almost dependent rows lose more digits, by the condition number of A, and are
not covered. With this ε, contact ends at N < -ε P and stick ends at |T| > μ N + ε (1 + μ) P, where P is the sum of the
parts of all closed contacts. A load exactly at a limit then causes one decision only: the present law continues at
equality.
"""
STOPPED = 1e-8
"""Slip speed in space below which the slip ends with one straight step [m/s]."""
STOPPED_SQUARE = STOPPED**2
CLOSED = 1e-10
"""Gap, relative to 1 m or the greatest coordinate, below which a contact is closed."""
DEPENDENT = 1e-10
"""Part of a row of A above which it counts as independent of others."""
