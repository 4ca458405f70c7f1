"""Lanes on the command line: ``--vary name=from:to:count`` for grids, ``--sample name=norm(0.5,0.05)`` for samples."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from typing import Any

import click

from ..errors import SimulationError, nearest
from .model import number_of


class Range(click.ParamType):
    """``name=from:to:count`` or ``name=a,b,c`` on the command line."""

    name = "name=from:to:count"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, str]:
        """Return name and values as texts."""
        if isinstance(value, tuple):
            return value
        name, sign, text = value.partition("=")
        if not sign or not name.strip() or not text.strip():
            self.fail(f"Expected name=from:to:count or name=a,b,c, got '{value}'.", param, ctx)
        parts = text.split(":")
        if ":" in text and (len(parts) != 3 or not parts[2].strip().isdigit() or int(parts[2]) < 2):
            self.fail(f"Expected name=from:to:count, with a count of at least 2, got '{value}'.", param, ctx)
        return name.strip(), text


class Distribution(click.ParamType):
    """``name=norm(0.5,0.05)`` or ``name=low:high`` on the command line."""

    name = "name=distribution"
    form = re.compile(r"\s*([^=]+?)\s*=\s*(?:([A-Za-z_]\w*)\s*\((.*)\)|([^:()]+):([^:()]+))\s*")

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, str, str]:
        """Return the name, the name of the distribution (empty for a pair), and its numbers as texts."""
        if isinstance(value, tuple):
            return value
        match = self.form.fullmatch(value)
        if match is None:
            self.fail(f"Expected name=norm(0.5,0.05) or name=low:high, got '{value}'.", param, ctx)
        name, distribution, arguments, low, high = match.groups()
        return (name, distribution, arguments) if distribution else (name, "", f"{low},{high}")


def grid(system: Any, vary: Iterable[tuple[str, str]]) -> Any:
    """Return the grid of ``--vary``."""
    from ..studies.lanes.grid import grid as law

    axes: dict[str, list[float]] = {}
    for name, text in vary:
        if name in axes:
            raise click.BadParameter(f"'{name}' is varied twice.", param_hint="--vary")
        axes[name] = numbers_of(system, name, text)
    return law(axes)


def numbers_of(system: Any, name: str, values: str) -> list[float]:
    """Return the numbers of ``from:to:count`` or ``a,b,c``, in the unit that the system declares for the name."""
    if ":" not in values:
        return [number_of(system, name, text, "--vary") for text in values.split(",")]
    *ends, last_part = values.split(":")
    first, last = (number_of(system, name, text, "--vary") for text in ends)
    count = int(last_part)
    return [first + (last - first) * k / (count - 1) for k in range(count)]


def sample(system: Any, draws: Iterable[tuple[str, str, str]], n: float | None, by: str, seed: int) -> Any:
    """Return the sample of ``--sample``, ``--n``, ``--by`` and ``--seed``."""
    from ..studies.lanes.sample import sample as law

    if n is None:
        raise click.UsageError("Expected the number of lanes of --sample: add --n 1000.")
    distributions: dict[str, Any] = {}
    for name, distribution, arguments in draws:
        if name in distributions:
            raise click.BadParameter(f"'{name}' is drawn twice.", param_hint="--sample")
        distributions[name] = distribution_of(system, name, distribution, arguments)
    return law(distributions, n, by=by, seed=seed)  # type: ignore[arg-type]  # whole numbers may be written 1e6


def distribution_of(system: Any, name: str, distribution: str, arguments: str) -> Any:
    """Return a distribution of scipy.stats, or a pair for a uniform one.

    Places and widths have the unit that the system declares for the name; parameters of shape have none.
    """
    texts = [text.strip() for text in arguments.split(",")] if arguments.strip() else []
    if not distribution:
        low, high = (number_of(system, name, text, "--sample") for text in texts)
        return (low, high)
    import scipy.stats

    known = [key for key, x in vars(scipy.stats).items() if isinstance(x, _generic())]
    hint = f"--sample {name}"
    if distribution not in known:
        raise click.BadParameter(
            f"Expected a distribution of scipy.stats, got '{distribution}'; {nearest(distribution, known)}",
            param_hint=hint,
        )
    family = getattr(scipy.stats, distribution)
    shapes = [x.strip() for x in (family.shapes or "").split(",") if x.strip()]
    places = [*shapes, "loc", *(["scale"] if hasattr(family, "pdf") else [])]
    numbers: dict[str, float] = {}
    for k, text in enumerate(texts):
        key, sign, value = text.rpartition("=")
        key = key.strip() if sign else places[k] if k < len(places) else "another"
        if key not in places or key in numbers:
            raise click.BadParameter(
                f"Expected {distribution}({', '.join(places)}), got {distribution}({arguments}).",
                param_hint=hint,
            )
        numbers[key] = (
            _shape(value, key, hint) if key in shapes else number_of(system, name, value.strip(), "--sample")
        )
    if missing := [key for key in shapes if key not in numbers]:
        raise click.BadParameter(
            f"Expected {distribution}({', '.join(places)}), got {distribution}({arguments}): {missing[0]} is missing.",
            param_hint=hint,
        )
    in_order = [numbers[key] for key in places[: len(numbers)] if key in numbers]
    return family(*in_order) if len(in_order) == len(numbers) else family(**numbers)


def _generic() -> tuple[type, type]:
    """Return the kinds of the distributions of scipy.stats."""
    from scipy.stats import rv_continuous, rv_discrete

    return rv_continuous, rv_discrete


def _shape(text: str, key: str, hint: str) -> float:
    """Return a parameter of shape, which has no unit."""
    from .model import Number

    convert: Callable[..., float] = Number("1").convert
    try:
        return convert(text.strip(), None, None)
    except click.BadParameter as error:
        raise click.BadParameter(f"{key}: {error.message}", param_hint=hint) from None


def law_of(system: Any, options: dict[str, Any]) -> Any:
    """Return the law of the lanes that the options of a command ask for."""
    if options["vary"] and options["sample"]:
        raise click.UsageError("Expected --vary, a grid, or --sample, draws; got both. Leave one out.")
    if options["sample"]:
        return sample(system, options["sample"], options["n"], options["by"] or "sobol", options["seed"] or 1)
    for name in ("n", "by", "seed"):
        if options[name] is not None:
            raise click.UsageError(
                f"Expected --sample with --{name}: it says how lanes are drawn. Leave it out."
            )
    if not options["vary"]:
        raise click.UsageError(
            "Expected what varies: --vary NAME=FROM:TO:COUNT, or --sample 'NAME=norm(0.5,0.05)' --n 1000."
        )
    try:
        return grid(system, options["vary"])
    except SimulationError as error:
        raise click.BadParameter(str(error), param_hint="--vary") from None
