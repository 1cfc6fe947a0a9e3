"""Mehrotra's predictor–corrector interior point for Eq. 7 in the low-rank form."""

from __future__ import annotations

import numpy as np
from scipy.linalg import lapack

from incsvr.samples import Array


def minimise(L: Array, y: Array, bound: Array, tube: Array) -> tuple[Array, int]:
    """θ (n,) that minimises ½‖Lᵀθ‖² + Σ εᵢ|θᵢ| − yᵀθ over |θᵢ| ≤ Cᵢ, and the number of iterations."""
    n, rank = L.shape
    LT = np.ascontiguousarray(L.T)
    eye = np.eye(rank)
    w = lapack.dposv(LT @ L + 1e-6 * max(1.0, n) * eye, LT @ y)[1]
    residual = y - L @ w
    C2 = np.vstack([bound, bound])
    scale = np.abs(residual).mean() + tube.mean() + 1e-12 * np.abs(y).max() + 1e-300
    mu = 0.1 * scale * float(bound.mean())
    t = np.vstack([tube - residual, tube + residual])
    # every product of the start equals mu: on the central path but for w = Lᵀθ
    root = np.sqrt((C2 * t) ** 2 + 4 * mu * mu)
    s = (C2 * t + 2 * mu + root) / (2 * C2)
    xi = (-C2 * t + 2 * mu + root) / (2 * C2)
    X = np.vstack([mu / s, mu / xi])
    S = np.vstack([s, xi])
    sign = np.array([[1.0], [-1.0]])
    first = None
    for _iteration in range(60):
        Q = S / X
        D = 1.0 / (Q[:2] + Q[2:])
        M = (LT * (D[0] + D[1])) @ L + eye
        chol, info = lapack.dpotrf(M, lower=1)
        if info:
            break
        rho = LT @ (X[0] - X[1]) - w
        XS = X * S
        mu = XS.mean()
        G = S[2:] - S[:2]
        P = D * G
        dw = lapack.dpotrs(chol, LT @ (P[0] - P[1]) + rho, lower=1)[0]
        da = D * (G - sign * (L @ dw))
        R = np.vstack([da, -da]) / X
        step = min(1.0, 1.0 / max(float(-R.min()), float(1.0 + R.max()), 1e-300))
        dS = -S - Q * np.vstack([da, -da])
        mu_affine = ((X + step * R * X) * (S + step * dS)).mean()
        target = mu * min(1.0, max(mu_affine / mu, 0.0)) ** 3
        U = target / X - S * (1.0 - R * (1.0 + R))
        G = U[:2] - U[2:]
        P = D * G
        dw = lapack.dpotrs(chol, LT @ (P[0] - P[1]) + rho, lower=1)[0]
        da = D * (G - sign * (L @ dw))
        dX = np.vstack([da, -da])
        dS = U - Q * dX
        step = min(1.0, 0.995 / max(float((-dX / X).max()), float((-dS / S).max()), 1e-300))
        X += step * dX
        S += step * dS
        w += step * dw
        mu = (X * S).mean()
        if first is None:
            first = mu
        if not np.isfinite(mu) or mu < 1e-16 * first:
            break
    theta = X[0] - X[1]
    return np.clip(theta, -bound, bound), _iteration + 1
