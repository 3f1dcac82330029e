"""Estimated parameters: values, confidence intervals, and whether the data tell them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Callable, Sequence

import numpy as np
from scipy import optimize, stats

from ..poses import Array

CONFIDENCE = 0.95
_ROUNDING = 1e-4  # of a value, below which a difference does not count
_LEAST_SINGULAR = 1e-9  # of the largest, below which a direction is not told


@dataclass(frozen=True)
class Estimate:
    """A parameter as the data tell it, in SI units."""

    name: str
    value: float
    low: float
    high: float
    """Bounds of the 95 % confidence interval."""
    unit: str
    key: str = ""
    """The scene's key that takes the value; empty = no scene has it."""
    scene_value: float | None = None
    """The value that the scene has now."""
    why_not: str = ""
    """The reason why the data do not tell it; empty = they do."""
    samples: int = 0

    @property
    def is_told(self) -> bool:
        """Whether the data tell the value."""
        return not self.why_not

    def contains(self, value: float) -> bool:
        """Whether the interval has the value, or the estimate is equal to it but for rounding."""
        return self.low <= value <= self.high or abs(value - self.value) <= _ROUNDING * abs(value)

    def as_dict(self) -> dict[str, Any]:
        """For JSON: numbers that are not finite are null."""
        return {
            "name": self.name,
            "value": _finite(self.value),
            "low": _finite(self.low),
            "high": _finite(self.high),
            "unit": self.unit,
            "key": self.key or None,
            "scene_value": self.scene_value,
            "told": self.is_told,
            "why_not": self.why_not or None,
            "samples": self.samples,
        }

    def judged(self, prior: tuple[float, float] | None = None) -> Estimate:
        """With the reason why the data do not tell it: an interval that is not finite, that is wider than
        the range of possible values, or as wide as the value itself."""
        if self.why_not:
            return self
        width = self.high - self.low
        if not math.isfinite(width):
            return replace(self, why_not="the data leave it free")
        if prior is not None and width > prior[1] - prior[0]:
            return replace(
                self, why_not=f"the interval is wider than the possible range {prior[0]:g} to {prior[1]:g}"
            )
        return self


def untold(name: str, unit: str, why: str, key: str = "", scene_value: float | None = None) -> Estimate:
    """A parameter that the data do not tell."""
    return Estimate(name, math.nan, -math.inf, math.inf, unit, key, scene_value, why)


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


@dataclass(frozen=True)
class Fit:
    """Least squares of residuals and the covariance of the parameters, s^2 (J^T J)^-1."""

    values: Array
    covariance: Array
    freedom: int
    rms: float

    def interval(self, index: int) -> tuple[float, float]:
        """The 95 % interval of a parameter, by Student's distribution."""
        variance = self.covariance[index, index]
        if self.freedom < 1 or not math.isfinite(variance):
            return -math.inf, math.inf
        half = float(stats.t.ppf(0.5 + CONFIDENCE / 2, self.freedom)) * math.sqrt(max(variance, 0.0))
        return float(self.values[index]) - half, float(self.values[index]) + half

    def estimate(self, index: int, name: str, unit: str, **more: Any) -> Estimate:
        """The parameter as an estimate."""
        low, high = self.interval(index)
        return Estimate(name, float(self.values[index]), low, high, unit, **more)


def fit(
    residuals: Callable[[Array], Array],
    start: Sequence[float] | Array,
    low: Sequence[float] | Array,
    high: Sequence[float] | Array,
    jacobian: Callable[[Array], Array] | None = None,
) -> Fit:
    """The parameters between bounds with the least squares of the residuals, which have equal variance. A
    parameter that ends at a bound, or in a direction along which the residuals do not change, has an
    infinite variance."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    begin = np.clip(np.asarray(start, float), low + 1e-9 * (high - low), high - 1e-9 * (high - low))
    found = optimize.least_squares(
        residuals, begin, bounds=(low, high), x_scale="jac", jac=jacobian or "3-point", xtol=1e-10, ftol=1e-10
    )
    count = len(found.fun)
    free = np.flatnonzero(found.active_mask == 0)
    freedom = count - len(free)
    rms = float(np.sqrt(np.mean(found.fun**2))) if count else 0.0
    covariance = np.full((len(begin), len(begin)), np.inf)
    if freedom > 0 and len(free):
        inverse = _inverse_of_normal(found.jac[:, free])
        covariance[np.ix_(free, free)] = inverse * float(found.fun @ found.fun) / freedom
    return Fit(np.asarray(found.x), covariance, freedom, rms)


def _inverse_of_normal(jacobian: Array) -> Array:
    """(J^T J)^-1; infinite for parameters with a part in the null space of J."""
    scale = np.linalg.norm(jacobian, axis=0)
    used = scale > 0
    scale[~used] = 1
    _, singular, rows = np.linalg.svd(jacobian / scale, full_matrices=False)
    told = singular > _LEAST_SINGULAR * max(float(singular.max()), 1e-300)
    inverse = (rows[told].T / singular[told] ** 2) @ rows[told]
    hidden = np.sum(rows[~told] ** 2, axis=0) > 1e-6
    hidden |= ~used
    inverse = inverse / np.outer(scale, scale)
    inverse[hidden, :] = np.inf
    inverse[:, hidden] = np.inf
    return np.asarray(inverse)


def mean(values: Sequence[float] | Array, name: str, unit: str, **more: Any) -> Estimate:
    """The mean of independent values, with Student's interval."""
    data = np.asarray(values, float)
    if len(data) < 2:
        return untold(name, unit, f"{len(data)} samples, at least 2 are needed", more.get("key", ""))
    half = float(stats.t.ppf(0.5 + CONFIDENCE / 2, len(data) - 1)) * data.std(ddof=1) / math.sqrt(len(data))
    middle = float(data.mean())
    return Estimate(name, middle, middle - half, middle + half, unit, samples=len(data), **more)


def spread(deviation: float, freedom: int, name: str, unit: str, **more: Any) -> Estimate:
    """A standard deviation of Gaussian noise with so many degrees of freedom, by the chi-squared
    distribution."""
    if freedom < 2 or deviation == 0:
        why = "too few samples for a standard deviation" if freedom < 2 else "the readings do not change"
        return untold(name, unit, why, more.get("key", ""), more.get("scene_value"))
    tail = (1 - CONFIDENCE) / 2
    low = deviation * math.sqrt(freedom / float(stats.chi2.ppf(1 - tail, freedom)))
    high = deviation * math.sqrt(freedom / float(stats.chi2.ppf(tail, freedom)))
    return Estimate(name, deviation, low, high, unit, **more)


def share(hits: int, count: int, name: str, **more: Any) -> Estimate:
    """A probability from independent trials, with Clopper and Pearson's interval."""
    if count == 0:
        return untold(name, "1", "no trials", more.get("key", ""))
    tail = (1 - CONFIDENCE) / 2
    low = float(stats.beta.ppf(tail, hits, count - hits + 1)) if hits else 0.0
    high = float(stats.beta.ppf(1 - tail, hits + 1, count - hits)) if hits < count else 1.0
    return Estimate(name, hits / count, low, high, "1", samples=count, **more)


def bootstrap(
    statistic: Callable[[list[Any]], float], groups: Sequence[Any], count: int = 400, seed: int = 1
) -> tuple[float, float]:
    """The 95 % interval of a statistic by resampling independent groups (Efron's percentiles). Infinite
    with fewer than 4 groups."""
    if len(groups) < 4:
        return -math.inf, math.inf
    random = np.random.default_rng(seed)
    values = [
        statistic([groups[i] for i in random.integers(0, len(groups), len(groups))]) for _ in range(count)
    ]
    tail = 100 * (1 - CONFIDENCE) / 2
    low, high = np.percentile(values, [tail, 100 - tail])
    return float(low), float(high)
