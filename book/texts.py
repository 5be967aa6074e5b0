"""Texts of the report around its tables and figures."""

TITLE = "Tyre-road friction: chapter 8, reproduced and extended"

INTRODUCTION = """Every number and picture here is made by the commands of book, benchmarks and campaigns, with fixed
seeds, through the shipped estimators and their shipped parameters. Where the chapter used test drives, which
are not public, the figure is its simulated counterpart. The chapter's own numbers come from single runs; ours
are statistics over many.

The chapter is about what a car can learn of the road while it brakes. The friction of a tyre rises with its
slip up to a peak and falls beyond it, where the wheel runs away to a lock. Section 8.2 finds out on which side
of the peak a wheel is, by the sign of the slope, and lets a state machine release the brake. Section 8.3 fits the
whole curve to see where the peak will be. Section 8.4 measures the forces of a tyre by an accelerometer in it.

The table gives each statement of the chapter in our words. It agrees where a rule holds that was set for it: a
number of a single run must lie among the middle 90 % of our runs, which stand in brackets behind their median."""

CLOSED_LOOP = """The chapter gives pictures of single stops and no numbers for delay or utilisation, so these
tables stand alone. A missed or early detection counts as infinitely late. `exact` columns are noise-free with
the shortest window and zero thresholds: the sign flips within the documented delay of the filter and one
sample. `disagreement` is the time in which eta and the slip rate differ in sign, inequality (8.6). The
chapter expects it at the beginning of hard braking and in the release; where a row says 0, there was none
in these stops.

The supervisor uses a set of its own (`vote` of friction_slope.yaml), early rather than sure: what it loses against
the ideal is the build-up of torque, and releases that the noise of H triggers before the peak."""

IDENTIFICATION = """The chapter prints one noisy run for each surface; a median over many runs is the fairer
number and stands beside it. The methods take friction samples by dead-reckoned speed, their best documented
source. With the samples of (8.8) as printed and a differenced slip the errors are several times as large (first
table), and a part of the runs fails: the noise of these samples is 0.5 to 0.7 in mu, nearly all of it from the
speed sensor, so the chapter must have smoothed more than it states. Equation (8.11) is used with the factor 1/2
that its quadratic term lacks in print; without it the iteration diverges on wet and snow even without noise. LS
and RLS carry a bias of their model (8.12), which noise-free data show as well: 3.5 % on dry, 0.5 % on wet, 1.4
% on cobblestone, 0.2 % on snow. It explains most of the chapter's error of about 5 % on dry, and not that on
wet, which must come from the noise of its run. RLS equals LS at the end, as in the chapter. The chapter's
mu_max of 1.0014 for cobblestone does not follow from its parameters, which give 0.9986.

The chapter leaves open how its samples were smoothed and how fast the brake was applied. The first table has
other readings beside ours, and names those among whose runs the chapter's number is. rml_covariance is RML as
it is usually written: theta_2 stays where it starts, as the chapter reports of its own."""

SPEED = """The chapter's roads are reproduced by curves with its lambda_max, 0.1 and 0.13, and by its numbers
of samples from lambda_init = 0.07 to the ABS activation at 0.15. Its errors are those of single test drives;
ours are over many noisy runs. What the chapter concludes holds: the estimate is as good with estimated as
with measured speed (the column over_measured compares the two).
The column start is the reading of lambda_init: the fit begins beyond it with all samples of the braking (all), or
is given only those beyond it (beyond). With the second, RML+ML off the road depends on its few first samples, as
the chapter says.

The second table and the figures are of the driver's stops of section 8.2.3, on a car whose load moves and whose
tyres relax, by samples made with the load from the acceleration. There the methods of the chapter do worse, and
worse still with estimated speed: what holds for one corner does not hold for this car."""

SMART_TYRE = """The drives are simulated with a belt model; levels and shapes follow the chapter: about 25
degrees of patch length, a twin spike a revolution, shifts of a few degrees. The chapter's observations hold
in every phase, front and rear, at both pressures (they are tests), and at 1.6 bar the patch is longer and the
shift alike. The chapter shows no force errors; these tables do. Removing the speed trend removes the steady
part of Fx (air drag, rolling) with it: the correction of the README adds it back. The text's 10 ms of
constant speed for Omega_0 is less than a revolution and is read as seconds."""

DEFAULT = """The default estimator fits wheel speed, torque and speed at every sample at once, with the
curve's parameters; its error is that of the Cramer-Rao bound with its prior. Before the slip passes the peak
the data do not determine lambda_max: the estimate is then that of the prior, with valid = false and a wide
interval. Failures are counted, never left out."""

MEASURED = """On the BMW stop the logged brake torque is a demand, so the curve comes from the acceleration
and the slips of all wheels. Its acceleration and its reference speed probably share a source (integrated,
they agree to 0.016 m/s): the speed error there is no independent proof. The laps of the Indy car hold no
strong braking, and the estimator stays silent. On the tyre rig the sweeps end at 17.5 % slip, so lambda_max
is barely identifiable, and the intervals are wide."""

LIVE = """Separate processes over DDS on this machine; the delay is from the publication of the sensors to the
arrival of the supervisor's command. Machines differ and are shared: compare within one run. The lock-step run
is compared with the processors driven offline, sample by sample."""
