"""Draws the picture of the README from a real run: ``python docs/gyroscope.py``."""

from pathlib import Path

from freebody.gallery import entries
from freebody.picture.plots.plots import saved
from freebody.picture.plots.sphere import axis_path

if __name__ == "__main__":
    motion = entries()["gyroscope"].run().trajectory
    picture = Path(__file__).with_suffix(".png")
    saved(
        lambda: axis_path(motion, "rotor", title="Gyroscope, let go from rest: path of its shaft"), dpi=110
    )(picture)
