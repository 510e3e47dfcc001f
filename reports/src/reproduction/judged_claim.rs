//! Whether claims hold, and under which readings.

use serde::Serialize;

use super::claim::Claim;
use crate::vocabulary::claim_verdict::ClaimVerdict;

/// A claim, and what was seen.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JudgedClaim {
    /// The claim.
    pub claim: Claim,
    /// What was seen under each reading of the paper, that in good faith first; none where nothing could be.
    pub readings: Vec<Seen>,
    /// Under how many of the joint settings of open values it holds, and of how many; `None` where it does not depend on
    /// them.
    pub settings: Option<[usize; 2]>,
    /// The conclusion.
    pub verdict: ClaimVerdict,
}

/// What was seen under one reading.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Seen {
    /// The reading.
    pub reading: String,
    /// The numbers, in words.
    pub numbers: String,
    /// The difference between method and rival, with its 95 % interval, in words; empty where there is none.
    pub difference: String,
    /// Whether the claim holds so; `None` if these scans cannot decide that.
    pub holds: Option<bool>,
}

impl JudgedClaim {
    /// Judges `claim` by what was seen.
    pub fn new(claim: Claim, readings: Vec<Seen>, settings: Option<[usize; 2]>) -> Self {
        let verdict = verdict(&readings, settings);
        Self { claim, readings, settings, verdict }
    }
}

fn verdict(readings: &[Seen], settings: Option<[usize; 2]>) -> ClaimVerdict {
    let Some(good_faith) = readings.first() else { return ClaimVerdict::CannotBeTestedHere };
    if good_faith.holds == Some(true) {
        return ClaimVerdict::Holds;
    }
    let some = readings.iter().any(|it| it.holds == Some(true)) || settings.is_some_and(|it| it[0] > 0);
    match good_faith.holds {
        _ if some => ClaimVerdict::HoldsUnderSomeReadings,
        Some(_) => ClaimVerdict::DoesNotHold,
        None => ClaimVerdict::CannotBeTestedHere,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(holds: Option<bool>) -> Seen {
        Seen { reading: String::new(), numbers: String::new(), difference: String::new(), holds }
    }

    #[track_caller]
    fn check(readings: &[Option<bool>], settings: Option<[usize; 2]>, expected: ClaimVerdict) {
        let readings: Vec<Seen> = readings.iter().map(|it| seen(*it)).collect();
        assert_eq!(verdict(&readings, settings), expected);
    }

    #[test]
    fn good_faith_decides_and_what_else_holds_is_said() {
        check(&[Some(true), Some(false)], Some([0, 200]), ClaimVerdict::Holds);
        check(&[Some(false), Some(true)], None, ClaimVerdict::HoldsUnderSomeReadings);
        check(&[Some(false), Some(false)], Some([3, 200]), ClaimVerdict::HoldsUnderSomeReadings);
        check(&[Some(false), None], Some([0, 200]), ClaimVerdict::DoesNotHold);
        check(&[None], None, ClaimVerdict::CannotBeTestedHere);
        check(&[], None, ClaimVerdict::CannotBeTestedHere);
    }
}
