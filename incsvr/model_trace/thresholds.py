"""Every chosen number of the tracer, with its unit and its reason; docs/tracer.md says what the prices of effects earn.

What floating point and the steps of integrators and solvers ask for stands in their files.
"""

from __future__ import annotations

# The model.
KNOT_RATE_SHARES = (0.25, 0.5, 0.75)
"""Knots of the damping's slope, in parts of the usual fastest rate: fewer bend too little for a drag crisis."""
SLOPE_PRIOR_DEVIATION = 0.3
"""Deviation of neighbouring slopes from each other, in parts of the largest torque over the fastest rate."""
OFFSET_PRIOR_PERIODS = 0.5
"""Deviation of the streams' offset, in periods of the slower stream: a stamp is somewhere within its period."""
TABLED_RATE_QUANTILES = (0.002, 0.998)
"""Quantiles of the rates between which the damping was learned."""

# Cells and windows.
CELLS_PER_SETTLING = 4.0
"""Cells in the time in which the vehicle settles: the integrator is of second order, thrust is exact in each."""
MIN_WINDOWS = 60
"""Windows at least. One lasts a time scale of the motion: half of it lets the water at its beginning bias the inertia,
two and five predict vehicles alike. Where so few fit into the recordings it is shorter."""
MIN_WINDOW_SETTLINGS = 1.5
"""Settling times down to which a window is shorter."""
MIN_WINDOW_CELLS = 4
"""Cells of a window at least."""
MAX_WINDOW_CELLS = 50
"""Cells of a window at most."""
MAX_WINDOWS = 800
"""Windows that are fitted; of more, these are spread evenly over the recordings: twelve minutes have fewer."""
MAX_INNOVATIONS = 12_000
"""Innovations that are fitted; of more, stretches are spread evenly over the recordings: twenty minutes at 10 Hz."""
SUBSTEP_SETTLINGS = 0.15
"""Part of the settling time that one integration step may last in a cell between two commands: a cell's error has the
shape of an inertia otherwise."""
MAX_SUBSTEPS = 6
"""Integration steps in a cell at most."""
MIN_PIECE_CELLS = 6
"""Cells of a piece below which it is left out."""
USUAL_QUANTILES = (0.02, 0.98)
"""Quantiles of rates, torques and channels between which they count as usual: a few wrong samples do not move them."""
SPIKE_NEIGHBOURS = 6.0
"""Differences between its neighbours beyond which a single sample is a spike."""
SPIKE_BENDS = 12.0
"""Usual bends of the stream beyond which that sample must be, besides."""
MAX_STAMP_ERROR_PERIODS = 0.25
"""Part of a period that stamps may be off an even grid before they are no longer taken for its edges."""
ALIKE_PERIOD_RANGE = (0.6, 1.6)
"""Period of the torque over that of the gyro between which cells begin with commands, else with samples of the gyro."""
STRETCH_SCALES = 40.0
"""Length in time scales of the stretches that are kept of long recordings: ten blocks that count as independent."""
START_REFLECTIONS = (-0.8, 0.0)
"""Reflections from which the colour is searched: much of the gyro's noise."""

# The fit.
STUDENT_DEGREES = 6.0
"""Degrees of freedom of Student's t, the law of the errors: heavy enough for spikes of a gyro, near Gaussian else."""

# The choice of effects, on windows or innovations that a fit did not see.
FOLDS = 4
"""Parts that are left out in turns where there are fewer than MIN_RUNS recordings."""
MIN_RUNS = 3
"""Recordings from which on whole ones are left out: a stand-in for one dive rarely serves another."""
BLOCK_WINDOWS = 4.0
"""Length of a block whose differences count as independent, in windows."""
MIN_BLOCKS = 24
"""Blocks at least; where so few would be left, they are shorter."""
INDEPENDENT_BLOCK_SCALES = 4.0
"""Length of a block whose differences count as independent, in time scales of the motion: well above the errors'
correlation time."""
STEADY_STANDARD_ERRORS = 2.0
"""Standard errors by which an effect must predict better beside its evidence."""
VERY_STEADY_STANDARD_ERRORS = 3.7
"""Standard errors by which it must predict windows better without that evidence: one false name in a hundred recordings
for forty candidates."""
WINDOW_EVIDENCE = 12.0
"""Logarithm of the likelihood ratio on unseen windows that an effect must bring, beyond that of its own search."""
INNOVATION_EVIDENCE = 30.0
"""Logarithm of the likelihood ratio on unseen innovations that an effect must bring: they are many, and what the
errors' colour misses of the water adds up over all of them."""
RELEVANT_ERROR_SHARE = 0.01
"""Part of the squared error of windows that an effect must take away."""
RELEVANT_FREE_RUN_SHARE = 0.03
"""Part of the free run's error on the usual held-out piece that each named effect must take away in open loop: what a
reader of the prediction would not see is not named."""
RELEVANT_TORQUE_SHARE = 0.02
"""Part of the torque's root mean square that an effect must move: no thrust table is better known."""
ALIKE_EVIDENCE = 3.0
"""Logarithm of the likelihood ratio on unseen data within which two hypotheses are not told apart."""
FOLD_TURNS = 8
"""Turns in which each fold is visited: a fold is in so many places of a recording."""

# The search.
FITTED_LEADS = 5
"""Candidates that are fitted in full in each round."""
FITTED_PAIRS = 3
"""Pairs of a candidate with a free inertia that are fitted in full in each round."""
MAX_ALTERNATIVES = 8
"""Candidates that are fitted in place of a named effect, to see what cannot be told from it."""
MIN_LEAD_GAIN = 2.5
"""Rise of the log likelihood in one step below which a candidate is not fitted."""
MIN_PAIR_GAIN = 2.0
"""Rise of a pair beyond the better of its two alone from which it is tried."""
MAX_EFFECTS = 6
"""Effects that are looked for."""
TIED_STEP_RANGE = (0.5, 1.5)
"""Parts of a start within which its effect is believed to go on as it begins: a lag of half a second says nothing of a
longer one."""
MAX_LEADING_FORMS = 2
"""Forms of one effect that are fitted in a round at most: others would take the places of other effects."""

# What the torque is.
LOOP_DEVIATIONS = 3.5
"""Deviations by which the torque of the next cell follows the rate's surprise where a controller closes the loop: most
open loops stay below 2, controllers reach 4 to 60."""
LOOP_CORRELATION = 0.03
"""Correlation with which the torque follows the surprise at least."""
OTHER_GYRO_CORRELATION = 0.12
"""Correlation at least where the log's gyro does not tell the torque beforehand (0.12 to 0.6 there; of 70 open loops
one reached it)."""
OTHER_GYRO_SURPRISE = 0.9
"""Usual surprise of a changed torque to whom sees the log's gyro, in that to whom does not, beyond which the controller
reads another gyro or the torque is measured (0.00 to 0.83 with the same, 0.91 to 1.00 else)."""
TORQUE_PAST_CELLS = 9
"""Cells of its past from which the torque is predicted."""
RUNNING_MEAN_CELLS = (20.0, 100.0)
"""Lengths, in cells, of the running means from which the torque is predicted besides."""
WHITENING_LAGS = 3
"""Past values that whiten the present one."""
GYRO_SIGHT_SAMPLES = 6
"""Samples of the gyro that tell whether a controller reads it."""
MIN_TORQUE_CHANGES = 200
"""Changes of the torque from which on it is told whether a controller reads that gyro."""
SURPRISE_CLIP_DEVIATIONS = 3.0
"""Usual deviations at which a surprise is cut: a turn that was asked for is no answer."""

# What recordings must show.
MAX_GAIN_ERROR = 0.5
"""Largest relative standard error of the thrust's gain with which a recording can say anything."""
MIN_TURN_DEVIATIONS = 7.0
"""The fastest turns (99 %) in deviations of the gyro's noise below which nothing is learned."""
MIN_IDLE_TURN_DEVIATIONS = 35.0
"""The fastest turns below which nothing is learned where the torque is next to zero most of the time."""
MAX_IDLE_SHARE = 0.85
"""Share of the time for which the torque may be next to zero before that is asked."""
MIN_SAMPLES = 200
"""Samples of each stream, over all runs, from which on anything is concluded."""
MIN_HEADING_SAMPLES = 5
"""Samples of a heading that is looked at."""
IDLE_TORQUE_SHARE = 0.02
"""Part of the largest torque below which a torque is next to nothing."""
COPY_CORRELATION = 0.995
"""Correlation beyond which two channels are copies."""
FUNCTION_R2 = 0.95
"""R² beyond which a channel is a function of torque or yaw rate: it would put one side of the equation on both."""
MIN_STUCK_S = 5.0
"""Time for which a rate must stay exactly the same to be called stuck [s]."""
MIN_STUCK_SHARE = 0.1
"""Part of the recording that a stuck rate must last as well."""
MIN_STUCK_TORQUE_SHARE = 0.3
"""Deviation of the torque meanwhile, in that of the whole recording, that would have turned the vehicle: a vehicle at
rest, or one in a steady turn seen by a gyro coarser than its noise, may well show one value for long."""
MIN_CLIPPED_SHARE = 0.02
"""Part of the samples at the very end of the range beyond which that is no coincidence."""
MIN_CLIPPED_STAY = 3.0
"""Time for which a clipped rate stays at its end, in that for which it stays elsewhere: a stream that was held between
its samples repeats itself everywhere."""
MIN_CLIPPED_LEAP_STEPS = 2.0
"""Steps of the gyro's resolution by which a clipped rate leaves its end. One that is merely coarse leaves by one."""
MIN_CLIPPED_SAMPLES = 3
"""Samples in a row at the end of the range that are no coincidence."""
MIN_STUCK_SAMPLES = 10
"""Samples in a row of which the duration of a stuck rate is taken."""

# Errors on unseen data.
HORIZON_SCALES = (0.5, 1.0, 2.0, 5.0)
"""Time scales of the motion that the multi-step errors look ahead."""
MAX_HELD_OUT_PIECES = 8
"""Pieces of a recording that are held out in turns at most."""
MIN_PIECE_SCALES = 20.0
"""Time scales of the motion that each such piece lasts at least."""
TORQUE_BLOCK_SCALES = 0.25
"""Time scales in a block of the torque's error: within one the gyro's noise would be most of it."""

# What is left.
MAX_SMOOTH_TERMS = 3
"""Smooth terms of what nothing in the catalogue explains, at most: a reader follows no more."""
SMOOTH_LEADS = 3
"""Smooth terms that are fitted in full in each round."""
SPELL_WINDOW_SCALES = 6.0
"""Time scales over which loudness is averaged to see whether it comes in spells: shorter than a pause of the thrusters,
longer than what the noise's own correlation leaves."""
PERMUTED_NEIGHBOURS = 4
"""Neighbouring innovations that a permutation keeps together: what is left of their correlation."""
PERMUTATIONS = 999
"""Permutations, or shifts, of which chance is told: a p-value of a thousandth can be seen."""
MAX_PERMUTED = 4000
"""Innovations that are looked at; of more, means over neighbours."""
SPELL_P_VALUE = 0.005
"""Largest p-value of a residual that is called one disturbance no more."""
MAX_NAMED_SPELLS = 5
"""Spells that a sentence names."""
MIN_LOUDER_DEVIATION = 1.5
"""Deviation within the spells over that outside from which they matter; a sea that is a little rougher does not."""

# What is said.
MAX_REJECTED = 12
"""Candidates that are listed as looked at and not added."""
MUCH_LEFT_SHARE = 0.25
"""Part of the torque that a model leaves from which the headline says so: a thrust table is known to about a tenth."""
