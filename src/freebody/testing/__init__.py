"""Random machines and states, and the batteries that every kind of load, joint, contact and method passes.

A user's own kind is checked by the same batteries: :func:`check_load`, :func:`check_joint`, :func:`check_contact` and
:func:`check_method`.
"""

from __future__ import annotations

from .comparison import LARGEST_ERROR as LARGEST_ERROR
from .contact import check_contact as check_contact
from .joint import check_joint as check_joint
from .load import check_load as check_load
from .machines import JOINTS as JOINTS
from .machines import random_chain as random_chain
from .machines import random_inertia as random_inertia
from .machines import random_rotation as random_rotation
from .machines import random_system as random_system
from .machines import small_inertia as small_inertia
from .machines import small_rotation as small_rotation
from .method import check_method as check_method
from .states import polynomial_value as polynomial_value
from .states import random_state as random_state
from .states import state_values as state_values
