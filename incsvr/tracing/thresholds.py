"""Chosen numbers of the trace, each with its unit and its reason; those of the engine are keywords of its functions."""

from __future__ import annotations

# The model.
TABLED_RATE_QUANTILES = (0.002, 0.998)
"""Quantiles of the rates between which the damping was learned."""

STUDENT_DEGREES = 6.0
"""Degrees of freedom of Student's t, the law of the errors: heavy enough for spikes of a gyro, near Gaussian else."""

# Proof.
INDEPENDENT_BLOCK_SCALES = 4.0
"""Length of a block whose differences count as independent, in time scales of the motion: well above the errors'
correlation time."""

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
TORQUE_BLOCK_SCALES = 0.25
"""Time scales in a block of the torque's error: within one the gyro's noise would be most of it."""

# What is left.
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
