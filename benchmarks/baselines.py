"""What users would take instead of the incremental learner, behind one interface: data in, a damping curve out.

    predict = LeastSquares().fit(data)
    predict(rates)  # d(r), (n,) [N m] at (n,) yaw rates [rad/s]

The offline SVRs are B1 and B2 of Table I. The textbook's damping, d(r) = N_r r + N_rr r|r|, is fitted by least squares,
total and recursive, to the damping samples, and by the adaptive identifier to the streams. scikit-learn gives a
neural network and a least-squares SVR. All get the same declared inertia.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from typing import Protocol

import numpy as np
from scipy.linalg import eigh
from sklearn.exceptions import ConvergenceWarning
from sklearn.kernel_ridge import KernelRidge
from sklearn.model_selection import GridSearchCV, PredefinedSplit
from sklearn.neural_network import MLPRegressor

from incsvr.learning.dual import solve
from incsvr.learning.kernel import rbf
from incsvr.numerics import Array
from incsvr.signals.samples import Samples

GRID_C = (10.0, 100.0, 1000.0, 10000.0)
GRID_EPSILON = (0.1, 1.0, 2.0, 5.0)
GRID_GAMMA = (5.0, 10.0, 20.0, 30.0)
"""The paper's grid (Section IV-B)."""
FOLDS = 5
"""Folds of a cross-validation; every fifth sample is in the same one, so that each covers the whole run."""

Predict = Callable[[Array], Array]


@dataclass(frozen=True, slots=True)
class Data:
    """What one experiment gives to learn from.

    Attributes:
        samples: the damping samples (Eq. 5), in the order of their time.
        time: (m,) stamps of the yaw-rate stream [s], strictly increasing.
        yaw_rate: (m,) the yaw-rate stream [rad/s].
        torque: (m,) the torque at the same stamps [N m].
    """

    samples: Samples
    time: Array
    yaw_rate: Array
    torque: Array

    @staticmethod
    def of(samples: Samples, yaw_rate: tuple[Array, Array], torque: tuple[Array, Array]) -> Data:
        """Puts the streams, each (stamps [s], values), on the stamps of the yaw rate."""
        time, rate = yaw_rate
        return Data(samples, time, rate, np.interp(time, *torque))


class Baseline(Protocol):
    """A method that learns a damping curve."""

    def fit(self, data: Data) -> Predict:
        """The curve that the method learns from the data."""


@dataclass(frozen=True, slots=True)
class Expansion:
    """f(r) = Σ θⱼ κ(rⱼ, r): the curve of an SVR with γ [s²/rad²], (m,) support vectors [rad/s] and weights [N m]."""

    gamma: float
    support_rate: Array
    weight: Array

    def __call__(self, rate: Array) -> Array:
        return rbf(rate, self.support_rate, self.gamma) @ self.weight


@dataclass(frozen=True, slots=True)
class OfflineSVR:
    """An ε-SVR without bias on all samples at once (B1 and B2 of Table I), solved exactly.

    Attributes:
        gamma: γ of the kernel [s²/rad²].
        C: bound on the weights [N m].
        epsilon: half the height of the tube [N m].
    """

    gamma: float = 10.0
    C: float = 1000.0
    epsilon: float = 0.1

    def fit(self, data: Data) -> Expansion:
        x, y = data.samples.yaw_rate, data.samples.damping
        weight = solve(x, y, gamma=self.gamma, C=self.C, epsilon=self.epsilon).weight
        kept = np.abs(weight) > 1e-9 * self.C  # what the solver leaves inside the tube is rounding
        return Expansion(self.gamma, x[kept], weight[kept])

    @staticmethod
    def tuned(samples: Samples) -> OfflineSVR:
        """The best of the paper's grid by the mean absolute error of cross-validation; nothing is random."""
        svrs = [OfflineSVR(gamma, C, epsilon) for C, epsilon, gamma in product(GRID_C, GRID_EPSILON, GRID_GAMMA)]
        return min(svrs, key=lambda svr: svr.cross_validated(samples))

    def cross_validated(self, samples: Samples) -> float:
        """The mean absolute error of cross-validation [N m]."""
        x, y = samples.yaw_rate, samples.damping
        fold, errors = np.arange(y.size) % FOLDS, []
        for left_out in range(FOLDS):
            train, test = fold != left_out, fold == left_out
            weight = solve(x[train], y[train], gamma=self.gamma, C=self.C, epsilon=self.epsilon).weight
            errors.append(np.mean(np.abs(rbf(x[test], x[train], self.gamma) @ weight - y[test])))
        return float(np.mean(errors))


def linear_quadratic(linear: float, quadratic: float) -> Predict:
    """d(r) = N_r r + N_rr r|r| of N_r [N m s/rad] and N_rr [N m s²/rad²]."""
    return lambda rate: rate * (linear + quadratic * np.abs(rate))


@dataclass(frozen=True, slots=True)
class LeastSquares:
    """Ordinary least squares for N_r and N_rr on all samples."""

    def fit(self, data: Data) -> Predict:
        rate = data.samples.yaw_rate
        regressors = np.column_stack((rate, rate * np.abs(rate)))
        linear, quadratic = np.linalg.lstsq(regressors, data.samples.damping)[0]
        return linear_quadratic(float(linear), float(quadratic))


@dataclass(frozen=True, slots=True)
class TotalLeastSquares:
    """Total least squares for N_r and N_rr: the yaw rate has errors, too (the paper's [8]).

    The combination of r, r|r| and d that is smallest beside its own noise (S. Van Huffel & J. Vandewalle, The Total
    Least Squares Problem, 1991, ch. 10). An error e of the rate is one of 2|r|e in r|r|: both are weighed with their
    covariance. Where the rate's noise goes to zero it is ordinary least squares.

    Attributes:
        rate_noise: of a sample's yaw rate [rad/s].
        damping_noise: of a sample's damping [N m].
    """

    rate_noise: float = 0.001
    damping_noise: float = 4.0

    def fit(self, data: Data) -> Predict:
        rate, damping = data.samples.yaw_rate, data.samples.damping
        size, square = np.abs(rate), rate * np.abs(rate)
        noise = np.zeros((3, 3))
        noise[:2, :2] = np.array([[1.0, 2.0 * size.mean()], [2.0 * size.mean(), 4.0 * (size**2).mean()]])
        noise *= self.rate_noise**2
        noise[2, 2] = self.damping_noise**2
        columns = np.column_stack((rate, square, damping))
        smallest = eigh(columns.T @ columns, noise)[1][:, 0]
        linear, quadratic = -smallest[:2] / smallest[2]
        return linear_quadratic(float(linear), float(quadratic))


@dataclass(frozen=True, slots=True)
class RecursiveLeastSquares:
    """Least squares for N_r and N_rr, sample by sample, with exponential forgetting.

    Attributes:
        forgetting: weight of a sample when the next one comes, λ; its memory is 1/(1 − λ) samples.
        doubt: initial variance of both coefficients relative to the noise of a sample.
    """

    forgetting: float = 0.995
    doubt: float = 1e6

    def fit(self, data: Data) -> Predict:
        theta, covariance = np.zeros(2), self.doubt * np.eye(2)
        for rate, damping in zip(data.samples.yaw_rate.tolist(), data.samples.damping.tolist(), strict=True):
            regressor = np.array((rate, rate * abs(rate)))
            spread = covariance @ regressor
            gain = spread / (self.forgetting + regressor @ spread)
            theta = theta + gain * (damping - regressor @ theta)
            covariance = (covariance - np.outer(gain, spread)) / self.forgetting
            covariance = 0.5 * (covariance + covariance.T)  # else it loses its symmetry within hours
        return linear_quadratic(float(theta[0]), float(theta[1]))


@dataclass(frozen=True, slots=True)
class AdaptiveIdentifier:
    """The adaptive identifier of Smallwood & Whitcomb, "Adaptive identification of dynamically positioned underwater
    robotic vehicles", IEEE Trans. Control Systems Technology 11(4), 2003, for yaw with a declared inertia.

    A copy of the plant follows the measured rate, I r̂̇ = τ − N̂_r r − N̂_rr r|r| + k (r − r̂), and its error turns the
    coefficients: dN̂/dt = −Γ φ(r) (r − r̂), φ = (r, r|r|). Stable in the sense of Lyapunov for every k, Γ > 0; no
    differentiation. Γ is scaled so that both coefficients settle within about `settling`.

    Attributes:
        inertia: I [kg m²].
        rate_scale: the vehicle's largest yaw rate [rad/s].
        follow: time constant of the copy, I/k [s].
        settling: time constant of the coefficients [s].
    """

    inertia: float = 350.0
    rate_scale: float = 0.25
    follow: float = 1.0
    settling: float = 30.0

    def fit(self, data: Data) -> Predict:
        follow = self.inertia / self.follow
        # Means of φ² over a sinusoid of amplitude rate_scale: R²/2 and 3R⁴/8.
        turn_linear = follow / (self.settling * self.rate_scale**2 / 2.0)
        turn_quadratic = follow / (self.settling * 3.0 * self.rate_scale**4 / 8.0)
        linear = quadratic = 0.0
        time, rates, torques = data.time.tolist(), data.yaw_rate.tolist(), data.torque.tolist()
        model = rates[0] if rates else 0.0
        for k in range(len(time) - 1):
            step, rate = time[k + 1] - time[k], rates[k]
            if step > self.follow:
                model = rates[k + 1]  # nothing is known of what happened in a gap
                continue
            square = rate * abs(rate)
            error = rate - model
            model += step / self.inertia * (torques[k] - linear * rate - quadratic * square + follow * error)
            linear -= step * turn_linear * rate * error
            quadratic -= step * turn_quadratic * square * error
        return linear_quadratic(linear, quadratic)


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
class NeuralNetwork:
    """A small neural network, as in the paper's [15]: one hidden layer of tanh, fitted by L-BFGS on all samples.

    Attributes:
        hidden: neurons.
        decay: weight of the squared weights, of the samples' scaled squared error.
    """

    hidden: int = 8
    decay: float = 1e-2

    def fit(self, data: Data) -> Predict:
        x, y = data.samples.yaw_rate, data.samples.damping
        rate, damping = float(np.std(x)), float(np.std(y))
        network = MLPRegressor(hidden_layer_sizes=(self.hidden,), activation="tanh", solver="lbfgs", alpha=self.decay,
                               max_iter=500, tol=1e-6, random_state=0)  # fmt: skip
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)  # it gets five hundred passes
            network.fit(x[:, None] / rate, y / damping)
        return lambda asked: np.asarray(network.predict(asked[:, None] / rate) * damping, dtype=np.float64)
