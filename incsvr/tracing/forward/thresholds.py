"""Every tuned number of the forward form, with its unit and its reason."""

from __future__ import annotations

KNOTS = 8
"""Of the damping's spline. Fewer bend too little for a drag crisis; more only follow the water."""

DEGREES = 6.0
"""Of freedom of Student's t, the law of the innovations: heavy enough for spikes of a gyro, near Gaussian else."""

SHIFT = 0.25
"""Deviation of what the torque's stamps may be off, in its sample periods: a stamp is somewhere within its period."""

REQUIRED_GAIN = 20.0
"""2 Δℓ above the price of its parameters that an effect must bring: a p-value of about 1e-5 for one parameter, so that
a search over thirty candidates and a hundred recordings still names next to nothing that is not there."""

MISFIT = 2.0
"""Times what the commands still tell of the innovations that an effect must bring besides: of hidden effects of full
size
the rest was at most a third of the gain, of the false ones with another gyro in the log more than half."""

RELEVANT = 0.02
"""Of the torque's root mean square that an effect must move: a thrust table is no better known."""

INDISTINGUISHABLE = 10.0
"""2 Δℓ within which an alternative explains the recordings as well."""

ANSWERS, NOISY = 12.0, 5.0
"""Standard errors by which the torque must follow the innovations of the rate before a controller is said to close the
loop (development missions under heading control: 15 to 122; open loop, also with effects hidden: at most 8), and by
which it must go against them before its sensor is said to have noise."""

LEAST_KNOWN = 0.2
"""Largest relative standard error of the thrust's gain, I₀/I, with which a recording can say anything: beyond, the
inertia that the vehicle is declared with could be wrong by a half and nobody would see."""

LEAST_RATE = 7.0
"""The fastest turns (99 %) in deviations of the gyro's noise: below, the damping is that of noise."""

IDLE, IDLE_RATE = 0.85, 35.0
"""Share of the time with next to no torque from which a vehicle counts as holding still, and the fastest turns, in
deviations of the gyro's noise, above which it moved all the same: what the torque does for instants only, thrust curve,
rotor and stamps explain alike."""
