"""Laws of lanes: the values of lane k of a study, computed where lane k runs."""
