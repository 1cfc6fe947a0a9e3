"""Every chosen number of the tracer, with its unit and its reason; docs/tracer.md says what each earns."""

from __future__ import annotations

# The model.
KNOTS = (0.25, 0.5, 0.75)
"""Knots of the damping's slope, in parts of the usual fastest rate: fewer bend too little for a drag crisis."""
SLOPE_PRIOR = 0.3
"""Deviation of neighbouring slopes from each other, in parts of the largest torque over the fastest rate."""
OFFSET_PRIOR = 0.5
"""Deviation of the streams' offset, in periods of the slower stream: a stamp is somewhere within its period."""

# Cells and windows.
CELLS_A_SETTLING = 4.0
"""Cells in the time in which the vehicle settles: the integrator is of second order, thrust is exact in each."""
MIN_WINDOWS, MIN_SETTLINGS = 60, 1.5
"""A window lasts a time scale of the motion: half of it lets the water at its beginning bias the inertia, two and five
predict vehicles alike. Where so few fit into the recordings it is shorter, down to so many settling times."""
MIN_STEPS, MAX_STEPS = 4, 50
"""Cells of a window at least and at most."""
MAX_WINDOWS = 800
"""Windows that are fitted; of more, these are spread evenly over the recordings: twelve minutes have fewer."""
MAX_INNOVATIONS = 12_000
"""Innovations that are fitted; of more, stretches are spread evenly over the recordings: twenty minutes at 10 Hz."""
SUBSTEP = 0.15
"""Part of the settling time that one integration step may last in a cell between two commands: a cell's error has the
shape of an inertia otherwise."""
MAX_SUBSTEPS = 6
"""Integration steps in a cell at most."""

# The fit.
DEGREES = 6.0
"""Degrees of freedom of Student's t, the law of the errors: heavy enough for spikes of a gyro, near Gaussian else."""

# The choice of effects, on windows or innovations that a fit did not see.
FOLDS = 4
"""Parts that are left out in turns where there are fewer than MIN_RUNS recordings."""
MIN_RUNS = 3
"""Recordings from which on whole ones are left out: a stand-in for one dive rarely serves another."""
BLOCK_WINDOWS, MIN_BLOCKS = 4.0, 24
"""Length of a block whose differences count as independent, in windows; less where so few blocks would be left."""
BLOCK_SCALES = 4.0
"""The same of innovations, in time scales of the motion."""
STEADY, VERY_STEADY = 2.0, 3.7
"""Standard errors by which an effect must predict better beside its evidence; and without it, of windows: one false
name in a hundred recordings for forty candidates."""
EVIDENCE_WINDOWS, EVIDENCE_INNOVATIONS = 12.0, 30.0
"""Logarithm of the likelihood ratio on unseen data that an effect must bring, beyond that of its own search.
Innovations are many, and what the errors' colour misses of the water adds up over all of them."""
RELEVANT_ERROR = 0.01
"""Part of the squared error of windows that an effect must take away."""
RELEVANT_FREE_RUN = 0.03
"""Part of the free run's error on the usual held-out piece that each named effect must take away in open loop: what a
reader of the prediction would not see is not named."""
RELEVANT_TORQUE = 0.02
"""Part of the torque's root mean square that an effect must move: no thrust table is better known."""
ALIKE = 3.0
"""Logarithm of the likelihood ratio on unseen data within which two hypotheses are not told apart."""

# The search.
LEADS, PAIRS = 5, 3
"""Candidates, and pairs of one with a free inertia, that are fitted in full in each round."""
ALTERNATIVES = 8
"""Candidates that are fitted in place of a named effect, to see what cannot be told from it."""
MIN_GAIN = 2.5
"""Rise of the log likelihood in one step below which a candidate is not fitted."""
PAIR_GAIN = 2.0
"""By how much a pair must rise beyond the better of its two alone to be tried."""
MAX_EFFECTS = 6
"""Effects that are looked for."""

# What the torque is.
REPEATED = 0.3
"""Share of torque messages that repeat the one before from which the torque is a command that holds."""
LOOP_DEVIATIONS, LOOP_CORRELATION, OTHER_GYRO_CORRELATION = 3.5, 0.03, 0.12
"""A controller closes the loop where the torque of the next cell follows the rate's surprise by so many deviations, and
with so large a correlation (most open loops stay below 2, controllers reach 4 to 60); with the last, where the log's
gyro does not tell the torque beforehand (0.12 to 0.6 there; of 70 open loops one reached it)."""
OTHER_GYRO = 0.9
"""Usual surprise of a changed torque to whom sees the log's gyro, in that to whom does not, beyond which the controller
reads another gyro or the torque is measured (0.00 to 0.83 with the same, 0.91 to 1.00 else)."""

# What recordings must show.
MAX_GAIN_ERROR = 0.5
"""Largest relative standard error of the thrust's gain with which a recording can say anything."""
MIN_TURN, MIN_IDLE_TURN, IDLE_SHARE = 7.0, 35.0, 0.85
"""The fastest turns (99 %) in deviations of the gyro's noise below which nothing is learned; the same where the torque
is next to zero for more than this share of the time."""
