"""The closed form of the evidence against the normal density that it stands for."""

from __future__ import annotations

import numpy as np
from scipy.stats import multivariate_normal

from incsvr.checks.evidence import Evidence


def test_the_evidence_of_each_cause_is_the_marginal_likelihood_of_the_samples() -> None:
    rng = np.random.default_rng(3)
    usual, shapes = rng.normal(size=(30, 3)), rng.normal(size=(30, 4))
    spread, mean, prior = np.array([0.3, 1.0, 2.0, 0.1]), np.array([0.0, 1.0, -0.5, 2.0]), np.array([1.0, 0.2, 3.0])
    error = usual @ [0.5, -0.1, 1.0] + shapes[:, 1] + rng.normal(size=30)
    columns = np.column_stack((usual, shapes, error))
    directions = np.concatenate((np.zeros((3, 4)), np.eye(4)))
    said = Evidence.of(columns.T @ columns, np.diag(prior**-2.0), directions, mean, spread)
    around = np.eye(30) + (usual * prior**2) @ usual.T

    def density(j: int | None) -> float:
        middle = np.zeros(30) if j is None else mean[j] * shapes[:, j]
        more = 0.0 if j is None else spread[j] ** 2 * np.outer(shapes[:, j], shapes[:, j])
        return float(multivariate_normal(middle, around + more).logpdf(error))

    nothing = density(None)
    assert np.isclose(said.nothing - 15.0 * np.log(2.0 * np.pi), nothing)
    assert np.allclose(said.odds, [density(j) - nothing for j in range(4)])
    assert int(np.argmax(said.odds)) == 1
    assert abs(said.size[1] - 1.0) < 3.0 * said.deviation[1]
