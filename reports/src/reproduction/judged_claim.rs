//! Verdicts on claims, and the readings under which they hold.

use serde::Serialize;

use super::claim::Claim;
use super::steps::Basis;
use crate::vocabulary::claim_verdict::ClaimVerdict;

/// A claim with its results and its verdict.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JudgedClaim {
    /// The claim.
    pub claim: Claim,
    /// The result under each reading of the paper: good faith first, and of each basis the reading that needs least first;
    /// empty if nothing could be tested.
    pub readings: Vec<Seen>,
    /// Number of joint settings of open values under which it holds, and of all settings; `None` where it does not depend on
    /// them.
    pub settings: Option<[usize; 2]>,
    /// The verdict.
    pub verdict: ClaimVerdict,
}

/// The result under one reading.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Seen {
    /// The reading.
    pub reading: String,
    /// The basis of the reading.
    pub basis: Basis,
    /// The numbers, in words.
    pub numbers: String,
    /// The difference between method and rival, with its 95 % interval, in words; empty where there is none.
    pub difference: String,
    /// Whether the claim holds under it; `None` if these scans cannot decide that.
    pub holds: Option<bool>,
}

impl JudgedClaim {
    /// Judges `claim` by the results under its `readings`.
    pub fn new(claim: Claim, readings: Vec<Seen>, settings: Option<[usize; 2]>) -> Self {
        let verdict = verdict(&readings, settings);
        Self { claim, readings, settings, verdict }
    }

    /// The verdict, with what it needs: the first reading of the best basis under which the claim holds.
    pub fn conclusion(&self) -> String {
        let name = self.verdict.name();
        match needed(&self.readings) {
            Some(needed) if needed.basis > Basis::Text => format!("{name}: {}", needed.reading),
            _ => name.to_owned(),
        }
    }
}

/// The reading under which the claim holds whose basis has most of the text.
fn needed(readings: &[Seen]) -> Option<&Seen> {
    readings.iter().filter(|it| it.holds == Some(true)).min_by_key(|it| it.basis)
}

fn verdict(readings: &[Seen], settings: Option<[usize; 2]>) -> ClaimVerdict {
    let Some(good_faith) = readings.first() else { return ClaimVerdict::CannotBeTestedHere };
    let by_basis = needed(readings).map(|it| match it.basis {
        Basis::Text => ClaimVerdict::Holds,
        Basis::Open => ClaimVerdict::HoldsWithReadings,
        Basis::Ours => ClaimVerdict::HoldsWithSteps,
        Basis::RivalDenied => ClaimVerdict::HoldsIfRivalDenied,
    });
    let by_settings = settings.is_some_and(|it| it[0] > 0).then_some(ClaimVerdict::HoldsWithReadings);
    let otherwise = match good_faith.holds {
        Some(_) => ClaimVerdict::DoesNotHold,
        None => ClaimVerdict::CannotBeTestedHere,
    };
    by_basis.into_iter().chain(by_settings).min().unwrap_or(otherwise)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen((basis, holds): (Basis, Option<bool>)) -> Seen {
        let reading = format!("{basis:?}");
        Seen { reading, basis, numbers: String::new(), difference: String::new(), holds }
    }

    #[track_caller]
    fn check(readings: &[(Basis, Option<bool>)], settings: Option<[usize; 2]>, expected: ClaimVerdict) {
        let readings: Vec<Seen> = readings.iter().copied().map(seen).collect();
        assert_eq!(verdict(&readings, settings), expected);
    }

    #[test]
    fn the_reading_that_has_most_of_the_text_decides() {
        use Basis::{Open, Ours, RivalDenied, Text};
        use ClaimVerdict::{
            CannotBeTestedHere, DoesNotHold, Holds, HoldsIfRivalDenied, HoldsWithReadings, HoldsWithSteps,
        };
        let (yes, no) = (Some(true), Some(false));
        check(&[(Text, yes), (Open, no)], Some([0, 200]), Holds);
        check(&[(Text, no), (Open, yes), (Ours, yes)], None, HoldsWithReadings);
        check(&[(Text, no), (Open, no), (Ours, yes), (RivalDenied, yes)], Some([0, 200]), HoldsWithSteps);
        check(&[(Text, no), (Open, no), (Ours, no), (RivalDenied, yes)], None, HoldsIfRivalDenied);
        // Settings have values that the text leaves open.
        check(&[(Text, no), (Ours, yes)], Some([3, 200]), HoldsWithReadings);
        check(&[(Text, no), (Open, None)], Some([0, 200]), DoesNotHold);
        check(&[(Text, None)], None, CannotBeTestedHere);
        check(&[], None, CannotBeTestedHere);
    }

    #[test]
    fn a_conclusion_says_what_the_verdict_needs() {
        let claim = crate::reproduction::claim::claims().remove(0);
        let readings =
            [(Basis::Text, Some(false)), (Basis::Ours, Some(true)), (Basis::RivalDenied, Some(true))];
        let judged = JudgedClaim::new(claim, readings.map(seen).to_vec(), None);
        assert_eq!(judged.conclusion(), "holds only with steps that are not in the text: Ours");
    }
}
