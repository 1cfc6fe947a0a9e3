"""The engine: one equation of motion, one integrator, one fit, for one axis or six.

    M ν̇ + C(ν) ν + Σ θ φ(ν, τ, η) = T(τ)(t − δ)

The model goes to the data: it is simulated at its own step under the exact mean effort of each step, and compared at
the sensors' own stamps. No measurement is resampled, smoothed or differentiated.
"""
