//! Claims of the papers whose verdict differs from that in the accepted run.

use crate::run_folder::run_archive::{ClaimName, ClaimRecord};
use crate::vocabulary::claim_verdict::ClaimVerdict;

/// A claim whose verdict changed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChangedClaim {
    /// The claim.
    pub claim: ClaimName,
    /// Its verdict in the accepted run.
    pub before: ClaimVerdict,
    /// Its verdict now; a run that does not judge it cannot test it.
    pub after: ClaimVerdict,
}

impl ChangedClaim {
    /// Whether less is left of it.
    pub fn is_worse(&self) -> bool {
        self.after > self.before
    }

    /// For people.
    pub fn in_words(&self) -> String {
        let ClaimName { paper, place, says } = &self.claim;
        let ChangedClaim { before, after, .. } = self;
        format!("Claim of {paper}, {place}, \"{says}\": {} → {}.", before.name(), after.name())
    }
}

/// The claims of `before` whose verdict in `after` is another one.
pub fn changed_claims(before: &[ClaimRecord], after: &[ClaimRecord]) -> Vec<ChangedClaim> {
    let changed = before.iter().filter_map(|it| {
        let now = after.iter().find(|now| now.claim == it.claim);
        let after = now.map_or(ClaimVerdict::CannotBeTestedHere, |it| it.verdict);
        (after != it.verdict).then(|| ChangedClaim { claim: it.claim.clone(), before: it.verdict, after })
    });
    changed.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(says: &str, verdict: ClaimVerdict) -> ClaimRecord {
        let [paper, place] = ["HG", "5, table 1"].map(str::to_owned);
        ClaimRecord { claim: ClaimName { paper, place, says: says.to_owned() }, verdict }
    }

    #[test]
    fn a_claim_that_held_and_no_longer_does_is_worse() {
        use ClaimVerdict::{CannotBeTestedHere, DoesNotHold, Holds, HoldsWithReadings};
        let before = [
            record("Same.", Holds),
            record("Lost.", Holds),
            record("Won.", DoesNotHold),
            record("Gone.", HoldsWithReadings),
        ];
        let after = [record("Won.", Holds), record("Lost.", HoldsWithReadings), record("Same.", Holds)];
        let changed = changed_claims(&before, &after);
        let found: Vec<_> = changed.iter().map(|it| (&*it.claim.says, it.after, it.is_worse())).collect();
        let expected =
            [("Lost.", HoldsWithReadings, true), ("Won.", Holds, false), ("Gone.", CannotBeTestedHere, true)];
        assert_eq!(found, expected);
        assert_eq!(
            changed[0].in_words(),
            "Claim of HG, 5, table 1, \"Lost.\": holds → holds with readings that the text leaves open."
        );
    }
}
