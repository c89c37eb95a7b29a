//! Whether an answer can be trusted.

use core::fmt;

use super::{ErrorSource, Estimate};
use crate::value::{Components, Value};

/// Whether there are reasons to doubt an answer or its error bar.
///
/// # Example
///
/// Of x^(−3/4) on [0, 1] the mean exists, but not the variance:
///
/// ```
/// use estimand::prelude::*;
/// use estimand::estimate::{Diagnosis, Symptom};
///
/// let estimate = monte_carlo(|x: f64| x.powf(-0.75), Interval::unit(), &Stop::samples(10_000))?.answer;
/// let Diagnosis::Doubtful(doubts) = estimate.diagnosis() else { unreachable!() };
/// assert!(doubts.iter().any(|d| matches!(d.symptom, Symptom::HeavyTail { shape, .. } if shape > 0.5)));
///
/// let smooth = monte_carlo(|x: f64| x.exp(), Interval::unit(), &Stop::samples(10_000))?.answer;
/// assert_eq!(smooth.diagnosis(), Diagnosis::Trusted);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Notes
///
/// What no sample has touched leaves no trace. A peak that all of them missed is not
/// doubted, by this or by anything else that sees the samples alone; nor is the tail
/// of values that are larger than any that occurred but follow another law.
#[derive(Clone, Debug, PartialEq)]
pub enum Diagnosis {
    /// Nothing was found that speaks against it.
    Trusted,
    /// These were found, one at least.
    Doubtful(Vec<Doubt>),
}

/// A reason to doubt an answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Doubt {
    /// Which component it concerns; `None` where the value has only one, or where
    /// it is all of them.
    pub component: Option<usize>,
    /// What was found.
    pub symptom: Symptom,
}

/// What speaks against an answer, with its figure. Prints with what to do about it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Symptom {
    /// Every value was 0.
    ZeroHits {
        /// How many they were.
        samples: u64,
    },
    /// Every value was the same.
    Constant {
        /// How many they were.
        samples: u64,
    },
    /// Values varied, but what the error bar was taken from did not.
    NoSpread,
    /// Too few samples, or replicates, to know how far the interval is right.
    TooFew {
        /// How many there were.
        found: f64,
        /// How many there should be.
        enough: f64,
    },
    /// The squares of the values are more than a float holds: no error bar.
    Overflow,
    /// Values that are NaN or infinite were left out.
    NonFinite {
        /// How many.
        count: u64,
        /// Of how many.
        samples: u64,
    },
    /// The largest values fall off so slowly that the variance may be infinite
    /// (k ≥ ½ cannot be excluded), and carry much of it. From k̂ = 0.7 on, the mean
    /// is not reliable either. In an estimate from within strata the values are the
    /// differences y − y′ of two samples of one stratum.
    HeavyTail {
        /// k̂, the fitted shape: P(|f/p| > y) falls like y^(−1/k).
        shape: f64,
        /// Its standard error.
        standard_error: f64,
        /// What part of Σ (f/p − ⟨I⟩)², or Σ (y − y′)², the values have that it was
        /// fitted to.
        share: f64,
    },
    /// One sample makes up much of the error bar; from within strata, two of one
    /// stratum, or a jump between neighbouring strata of which it may know nothing:
    /// it varies within a stratum only where samples lie on both sides.
    Dominated {
        /// Its part of Σ (f/p − ⟨I⟩)², or Σ (y − y′)².
        share: f64,
    },
    /// Two neighbouring strata differ as if the integrand jumped, and samples within
    /// neither of them did: so much as this may be missing from the error bar, which is
    /// made of what varies within strata.
    UnseenJump {
        /// The variance that a jump has whose place in one of them is not known, over
        /// that of the answer.
        share: f64,
    },
    /// The error bar rests on few values, or few strata.
    FewCarry {
        /// On how many, effectively: M₂²/M₄, or the degrees of freedom.
        effective: f64,
    },
    /// Values are so skewed that a t interval covers less than it says.
    Skewed {
        /// √n M₃/M₂^(3/2)
        skewness: f64,
        /// How much less a 95 % interval covers, to first order in 1/n.
        loss: f64,
    },
    /// Values cancel, or few of them are not next to 0: the answer is not many
    /// standard errors from 0.
    FewEffective {
        /// ⟨I⟩² / Var ⟨I⟩: how many equal values would know it as well.
        effective: f64,
    },
    /// Passes, or replicates, differ by more than their error bars explain.
    Disagree {
        /// The probability that they do so by chance.
        q: f64,
    },
    /// The answer grew in the last part of the run: something large was found late.
    Late {
        /// By how many standard errors.
        growth: f64,
    },
    /// What a map has learned, it has learned from few samples.
    Untaught {
        /// From how many, effectively, in its last lesson.
        effective: f64,
    },
    /// The expectation that was stated for a control variate is not what the samples
    /// say.
    Expectation {
        /// The number of the control variate.
        control: usize,
        /// How many standard errors they are apart.
        errors: f64,
    },
}

/// So many independent samples tell how heavy their tail is.
const SAMPLES: u64 = 100;
/// So many replicates, or degrees of freedom of strata, make a t interval useful.
const REPLICATES: f64 = 5.0;
/// A tail with a smaller part in the variance does not matter yet, whatever its
/// shape.
const TAIL_SHARE: f64 = 0.3;
/// The shape is doubted if k = ½ is less than so many standard errors above it: more
/// of them for replicates, where few means have to show what a singularity does, and
/// for strata of which fewer than so many count.
const SHAPE_ERRORS: f64 = 2.0;
const SHAPE_ERRORS_FEW: f64 = 3.0;
const STRATA: f64 = 64.0;
/// One sample may be so much of the variance, and the variance may rest on so few.
const LARGEST_SHARE: f64 = 0.2;
const CARRIERS: f64 = 30.0;
/// More of them for replicates, whose values may be as skewed as they like: what they
/// integrate exactly does not matter, and nothing is known of the skewness of the rest.
const CARRIERS_REPLICATES: f64 = 48.0;
/// Degrees of freedom are what Student's t makes up for, as far as it can.
const FREEDOM: f64 = 10.0;
/// A loss of 0.1 % of coverage at 95 %.
const LOSS: f64 = 0.001;
/// Some two standard errors.
const EFFECTIVE: f64 = 5.0;
const Q: f64 = 1e-3;
/// The same level, one-sided.
const GROWTH: f64 = 3.1;
const LESSON: f64 = 10.0;
const EXPECTATION: f64 = 5.0;

impl<V: Value> Estimate<V> {
    /// What speaks against this answer or its error bar.
    #[must_use]
    pub fn diagnosis(&self) -> Diagnosis {
        let mut doubts = Vec::new();
        let of_all = |symptom| Doubt {
            component: None,
            symptom,
        };
        let moments = &self.moments;
        let samples = moments.count() + moments.non_finite();
        if moments.non_finite() > 0 {
            doubts.push(of_all(Symptom::NonFinite {
                count: moments.non_finite(),
                samples,
            }));
        }
        let (found, enough) = match self.error_source {
            ErrorSource::Independent => (moments.count() as f64, SAMPLES as f64),
            ErrorSource::Replicates => (self.degrees_of_freedom + 1.0, REPLICATES),
            _ => (f64::INFINITY, 0.0),
        };
        if found < enough {
            doubts.push(of_all(Symptom::TooFew { found, enough }));
        }
        if self.evidence.lesson < LESSON {
            doubts.push(of_all(Symptom::Untaught {
                effective: self.evidence.lesson,
            }));
        }
        for k in 0..V::Components::COUNT {
            let component = (V::Components::COUNT > 1).then_some(k);
            let symptoms = self.component(k).map(|e| e.symptoms()).unwrap_or_default();
            let doubt = |symptom| Doubt { component, symptom };
            doubts.extend(symptoms.into_iter().map(doubt));
        }
        if doubts.is_empty() {
            Diagnosis::Trusted
        } else {
            Diagnosis::Doubtful(doubts)
        }
    }
}

impl Estimate<f64> {
    /// Those of a component.
    fn symptoms(&self) -> Vec<Symptom> {
        let moments = &self.moments;
        let samples = moments.count();
        if self.standard_error == 0.0 {
            return vec![if moments.largest() == 0.0 {
                Symptom::ZeroHits { samples }
            } else if moments.sum_of_squares() <= 0.0 {
                Symptom::Constant { samples }
            } else {
                Symptom::NoSpread
            }];
        }
        if !self.standard_error.is_finite() {
            let overflow = samples > 1 && !moments.sum_of_squares().is_finite();
            return vec![if overflow {
                Symptom::Overflow
            } else {
                Symptom::TooFew {
                    found: samples as f64,
                    enough: SAMPLES as f64,
                }
            }];
        }
        let mut symptoms = Vec::new();
        let mut doubt = |holds: bool, symptom| {
            if holds {
                symptoms.push(symptom);
            }
        };
        let evidence = &self.evidence;
        let ([shape], [standard_error]) = (evidence.shape, evidence.shape_error);
        let ([share], [largest]) = (evidence.tail_share, evidence.largest_share);
        let freedom = self.degrees_of_freedom;
        let errors = match self.error_source {
            ErrorSource::Replicates => SHAPE_ERRORS_FEW,
            ErrorSource::WithinStrata if freedom < STRATA => SHAPE_ERRORS_FEW,
            _ => SHAPE_ERRORS,
        };
        doubt(
            shape + errors * standard_error >= 0.5 && share >= TAIL_SHARE,
            Symptom::HeavyTail {
                shape,
                standard_error,
                share,
            },
        );
        doubt(
            largest >= LARGEST_SHARE,
            Symptom::Dominated { share: largest },
        );
        let [share] = evidence.jump_share;
        doubt(
            share >= LARGEST_SHARE && share > largest,
            Symptom::UnseenJump { share },
        );
        let n = samples as f64;
        let carriers = moments
            .excess_kurtosis()
            .map(|kurtosis| n / (kurtosis + 3.0));
        let rests_on = |effective: f64| Symptom::FewCarry { effective };
        match (self.error_source, carriers, moments.skewness()) {
            (ErrorSource::Independent, Some(carriers), Some(skewness)) if samples >= SAMPLES => {
                doubt(carriers < CARRIERS, rests_on(carriers));
                let loss = HALL * skewness * skewness / n;
                doubt(loss >= LOSS, Symptom::Skewed { skewness, loss });
            }
            (ErrorSource::Replicates, Some(carriers), _) => {
                doubt(carriers < CARRIERS_REPLICATES, rests_on(carriers));
            }
            (ErrorSource::Replicates, None, _) => {}
            _ => doubt(freedom < FREEDOM, rests_on(freedom)),
        }
        let ratio = self.mean / self.standard_error;
        let effective = ratio * ratio;
        doubt(effective < EFFECTIVE, Symptom::FewEffective { effective });
        let ([q], [growth]) = (evidence.agreement, evidence.growth);
        doubt(q < Q, Symptom::Disagree { q });
        doubt(growth > GROWTH, Symptom::Late { growth });
        symptoms
    }
}

/// What γ²/n takes from the coverage of a 95 % interval: z(z⁴ + 2z² − 3)/9 · φ(z).
///
/// Source: Hall, *The Bootstrap and Edgeworth Expansion* (1992), §2.6.
const HALL: f64 = 0.2475;

impl Diagnosis {
    /// Whether nothing was found.
    #[must_use]
    pub const fn is_trusted(&self) -> bool {
        matches!(self, Self::Trusted)
    }

    /// What was found; nothing where it is trusted.
    #[must_use]
    pub fn doubts(&self) -> &[Doubt] {
        match self {
            Self::Trusted => &[],
            Self::Doubtful(doubts) => doubts,
        }
    }

    /// With more reasons.
    pub(crate) fn and(self, more: impl IntoIterator<Item = Symptom>) -> Self {
        let mut doubts = match self {
            Self::Trusted => Vec::new(),
            Self::Doubtful(doubts) => doubts,
        };
        doubts.extend(more.into_iter().map(|symptom| Doubt {
            component: None,
            symptom,
        }));
        if doubts.is_empty() {
            Self::Trusted
        } else {
            Self::Doubtful(doubts)
        }
    }
}

impl Symptom {
    /// A control variate whose mean is so far off.
    pub(crate) fn expectation(control: usize, errors: f64) -> Option<Self> {
        (errors.abs() > EXPECTATION).then_some(Self::Expectation { control, errors })
    }
}

impl fmt::Display for Diagnosis {
    /// `trusted`, or `doubtful: …; …`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::Doubtful(doubts) = self else {
            return write!(f, "trusted");
        };
        for (i, doubt) in doubts.iter().enumerate() {
            write!(f, "{}{doubt}", if i == 0 { "doubtful: " } else { "; " })?;
        }
        Ok(())
    }
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(component) = self.component {
            write!(f, "component {component}: ")?;
        }
        self.symptom.fmt(f)
    }
}

impl fmt::Display for Symptom {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::ZeroHits { samples } => write!(
                f,
                "all {samples} values are 0: sample where f is not, or take more samples"
            ),
            Self::Constant { samples } => write!(
                f,
                "all {samples} values are the same: fine if f/p is constant, else the samples \
                 are not what they should be"
            ),
            Self::NoSpread => write!(
                f,
                "values vary, but the error bar is 0: take other strata or other points to \
                 compare with"
            ),
            Self::TooFew { found, enough } => write!(
                f,
                "{found:.0} samples or replicates are too few for an interval: take {enough:.0}"
            ),
            Self::Overflow => write!(
                f,
                "squares of the values overflow, and there is no error bar: scale the integrand"
            ),
            Self::NonFinite { count, samples } => write!(
                f,
                "{count} of {samples} values are NaN or infinite and were left out: see where, \
                 with NonFinite::Refuse"
            ),
            Self::HeavyTail {
                shape,
                standard_error,
                share,
            } => {
                let what = if shape >= 0.7 {
                    "the mean is unreliable"
                } else {
                    "the variance may be infinite"
                };
                write!(
                    f,
                    "{what}: the largest |f/p|, {:.0} % of the variance, have a tail of shape \
                     k = {shape:.2} ± {standard_error:.2}: sample more where |f|/p is large",
                    100.0 * share
                )
            }
            Self::Dominated { share } => write!(
                f,
                "one sample is {:.0} % of the variance: sample more where |f|/p is large",
                100.0 * share
            ),
            Self::UnseenJump { share } => write!(
                f,
                "neighbouring strata differ as if the integrand jumped where no sample saw it, \
                 which may be {:.0} % of the variance: take a pdf with an edge there",
                100.0 * share
            ),
            Self::FewCarry { effective } => write!(
                f,
                "the error bar rests on {effective:.1} effective values: take more samples, or \
                 sample more where |f|/p is large"
            ),
            Self::Skewed { skewness, loss } => write!(
                f,
                "a skewness of {skewness:.3} costs a 95 % interval about {:.1} % of coverage: \
                 take more samples, or skewed_interval",
                100.0 * loss
            ),
            Self::FewEffective { effective } => write!(
                f,
                "the answer is {:.1} standard errors from 0: where values cancel, integrate \
                 what is left of them; else take more samples",
                effective.sqrt()
            ),
            Self::Disagree { q } => write!(
                f,
                "passes or replicates disagree, by chance with probability {q:.0e}: something \
                 is found by few of them; take more samples, or sample more where |f|/p is large"
            ),
            Self::Late { growth } => write!(
                f,
                "the answer grew by {growth:.1} standard errors in the last part of the run: \
                 something large was found late; take more samples"
            ),
            Self::Untaught { effective } => write!(
                f,
                "the map learned from {effective:.1} effective samples: take more samples, or \
                 begin with a map or a pdf that knows where f is large"
            ),
            Self::Expectation { control, errors } => write!(
                f,
                "the mean of control variate {control} is {errors:.1} standard errors from the \
                 expectation that was stated: check that"
            ),
        }
    }
}
