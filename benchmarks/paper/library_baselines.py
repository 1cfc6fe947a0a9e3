"""Baselines that the paper cites and that well-kept libraries have: behind the same interface as the project's own."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from sklearn.exceptions import ConvergenceWarning
from sklearn.kernel_ridge import KernelRidge
from sklearn.model_selection import GridSearchCV, PredefinedSplit
from sklearn.neural_network import MLPRegressor

from benchmarks.paper.baselines import GRID_C, GRID_GAMMA, Data, Expansion
from incsvr.numerics import Array

FOLDS = 5


@dataclass(frozen=True, slots=True)
class LeastSquaresSVR:
    """The least-squares SVR of the paper's [16] without bias: min Σ (f(x) − y)² + ‖f‖²/C, a kernel ridge regression.

    C and γ are searched on the paper's grid by cross-validation, as the offline SVR's are. Every sample is a vector.
    """

    def fit(self, data: Data) -> Expansion:
        x, y = data.samples.yaw_rate, data.samples.damping
        grid = {"alpha": [1.0 / C for C in GRID_C], "gamma": list(GRID_GAMMA)}
        folds = PredefinedSplit(np.arange(y.size) % FOLDS)
        search = GridSearchCV(KernelRidge(kernel="rbf"), grid, scoring="neg_mean_absolute_error", cv=folds)
        found = search.fit(x[:, None], y).best_estimator_
        return Expansion(float(found.gamma), x, np.asarray(found.dual_coef_, dtype=np.float64))


@dataclass(frozen=True, slots=True)
class Network:
    """A fitted network: yaw rates and dampings are scaled to about one.

    Attributes:
        network: scikit-learn's.
        rate, damping: by what they are divided [rad/s], [N m].
    """

    network: MLPRegressor
    rate: float
    damping: float

    def predict(self, rate: Array) -> Array:
        return np.asarray(self.network.predict(rate[:, None] / self.rate) * self.damping, dtype=np.float64)


@dataclass(frozen=True, slots=True)
class NeuralNetwork:
    """A small neural network, as in the paper's [15]: one hidden layer of tanh, fitted by L-BFGS on all samples.

    Attributes:
        hidden: neurons.
        decay: weight of the squared weights, of the samples' scaled squared error.
    """

    hidden: int = 8
    decay: float = 1e-2

    @property
    def weights(self) -> int:
        return 3 * self.hidden + 1

    def fit(self, data: Data) -> Network:
        x, y = data.samples.yaw_rate, data.samples.damping
        rate, damping = float(np.std(x)), float(np.std(y))
        network = MLPRegressor(
            hidden_layer_sizes=(self.hidden,),
            activation="tanh",
            solver="lbfgs",
            alpha=self.decay,
            max_iter=500,
            tol=1e-6,
            random_state=0,
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)  # five hundred passes are what it gets
            network.fit(x[:, None] / rate, y / damping)
        return Network(network, rate, damping)
