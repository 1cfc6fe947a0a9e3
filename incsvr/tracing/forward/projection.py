"""What one more effect would explain beside a fit, the noise and the weights as they are: the scan's view."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from incsvr.tracing.forward.candidates import SLIGHT, bracket, unit
from incsvr.tracing.forward.equations import Part, columns, predicted, thrust
from incsvr.tracing.forward.fit import Fit
from incsvr.tracing.forward.grid import Grid
from incsvr.tracing.forward.regression import assemble

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Lead:
    """A candidate as the scan sees it: its start, and 2 Δℓ with the noise as it was."""

    part: Part
    gain: float


class Projection:
    """What one more effect explains of the whitened target beside a fit, the noise and the weights as they are."""

    def __init__(self, grid: Grid, fitted: Fit, instead: Part | None = None) -> None:
        """With `instead`, beside the fit without the part of that name."""
        self.grid, self.fitted = grid, fitted
        model = fitted.model
        if instead is not None:
            model = replace(model, parts=tuple(p for p in model.parts if p.name != instead.name))
        self.parts = model.parts
        self.regression = assemble(grid, model)
        self.root = np.sqrt(fitted.weight)
        self.rest = thrust(grid.signals, model.parts)
        white, white_y = self.regression.whitened(fitted.noise)
        self.frame = np.linalg.qr((white * self.root).T)[0]
        self.left = self._beside(white_y * self.root)

        self.signals = replace(predicted(grid, fitted.model).signals, residual=fitted.innovation)

    def _beside(self, values: Array) -> Array:
        return np.asarray(values - (values @ self.frame) @ self.frame.T)

    def seen(self, loss: Array) -> Array:
        """(…, n) a loss as it stands in the whitened equations beside the fit."""
        return self._beside(self.regression.whiten(self.fitted.noise, loss) * self.root)

    def _lost(self, part: Part) -> Array:
        """(n,) what a thrust effect takes of the thrust beside the others [N m]."""
        return np.asarray(self.rest - thrust(self.signals, [*self.parts, part]))

    def gain(self, part: Part) -> float:
        """2 Δℓ of a part whose searched parameter stands."""
        if part.thrust:
            seen = self.seen(self._lost(part))
            explained = float(2.0 * self.left @ seen - seen @ seen)
        else:
            seen = np.atleast_2d(self.seen(columns(part, self.signals)))
            gram = seen @ seen.T
            gram[np.diag_indices_from(gram)] *= 1.0 + 1e-9
            pull = seen @ self.left
            explained = float(pull @ np.linalg.lstsq(gram, pull)[0])
        return explained / self.fitted.sigma**2

    def try_start(self, part: Part) -> Lead:
        """The gain at a start; a thrust effect without one begins from its tangent."""
        if not part.thrust or part.effect.fixed_coefficient or part.effect.secant:
            return Lead(part, self.gain(part))
        size = SLIGHT * unit(part, self.signals)
        tangent = self.seen(self._lost(part.moved(size))) / size
        square = float(tangent @ tangent)
        value = float(self.left @ tangent) / square if square > 0.0 else 0.0
        limit = 0.6 * unit(part, self.signals)
        begun = part.moved(float(np.clip(value, -limit, limit)))
        return Lead(begun, self.gain(begun))

    def refined(self, part: Part) -> Part:
        """The part with its searched parameter, if it has one, where the gain is greatest."""
        if not part.searched:
            return part
        low, high = bracket(part, self.signals)
        if not high > low:
            return part
        found = minimize_scalar(
            lambda value: -self.gain(part.moved(float(value))), bounds=(low, high), method="bounded",
            options={"xatol": 1e-3 * (high - low), "maxiter": 16},
        )  # fmt: skip
        moved = part.moved(float(found.x))
        return moved if self.gain(moved) >= self.gain(part) else part
