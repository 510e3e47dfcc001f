//! The claims of the papers as a table.

use crate::reproduction::claim::Paper;
use crate::reproduction::judged_claim::JudgedClaim;
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::sheet::{Part, Sheet, Tabular};
use crate::vocabulary::claim_verdict::ClaimVerdict;

/// Judged claims with their notes.
#[derive(Debug, Clone, Copy)]
pub struct ClaimsTable<'a> {
    /// The claims.
    pub claims: &'a [JudgedClaim],
    /// The notes beneath.
    pub notes: &'a [String],
}

impl Tabular for ClaimsTable<'_> {
    fn sheet(&self) -> Sheet {
        let of_paper = |paper: Paper| {
            let claims: Vec<&JudgedClaim> = self.claims.iter().filter(|it| it.claim.paper == paper).collect();
            (!claims.is_empty())
                .then(|| Part { title: Some(paper.citation().to_owned()), grid: grid(&claims) })
        };
        let parts = Paper::ALL.into_iter().filter_map(of_paper).collect();
        let mut sheet = Sheet::of_parts(parts, self.notes.to_vec()).labelled("claims");
        sheet.lead.push(lead(self.claims));
        sheet
    }
}

/// How many claims hold, in a sentence.
pub fn lead(claims: &[JudgedClaim]) -> String {
    let counted = [
        (ClaimVerdict::Holds, "hold"),
        (ClaimVerdict::HoldsWithReadings, "hold with readings that the text leaves open"),
        (ClaimVerdict::HoldsWithSteps, "hold only with steps that are not in the text"),
        (ClaimVerdict::HoldsIfRivalDenied, "hold if the rival is denied something"),
        (ClaimVerdict::DoesNotHold, "do not hold"),
        (ClaimVerdict::CannotBeTestedHere, "cannot be tested here"),
    ]
    .map(|(verdict, said)| (claims.iter().filter(|it| it.verdict == verdict).count(), said));
    let said: Vec<String> =
        counted.into_iter().filter(|it| it.0 > 0).map(|(n, said)| format!("{n} {said}")).collect();
    format!("Of the claims ({}) {}.", claims.len(), said.join(", "))
}

fn grid(claims: &[&JudgedClaim]) -> Grid {
    let titles = ["claim", "place", "printed", "reading", "here", "difference (95 % interval)", "verdict"];
    let columns = titles.into_iter().map(Column::left).collect();
    let mut lines = Vec::new();
    for it in claims {
        let verdict = match it.settings {
            Some([n_holding, n]) => {
                format!("{} ({n_holding} of {n} settings)", it.conclusion())
            }
            None => it.conclusion(),
        };
        let claim = [it.claim.says.clone(), it.claim.place.clone(), it.claim.printed.clone()];
        let first = it.readings.first();
        let seen = first.map_or_else(
            || [String::new(), "–".to_owned(), String::new()],
            |it| [it.reading.clone(), it.numbers.clone(), it.difference.clone()],
        );
        lines.push(line(LineKind::Dataset, claim.into_iter().chain(seen).chain([verdict])));
        for seen in it.readings.iter().skip(1) {
            let holds = match seen.holds {
                Some(true) => "holds so",
                Some(false) => "does not",
                None => "not known",
            };
            let cells = [&seen.reading, &seen.numbers, &seen.difference].map(Clone::clone);
            let empty = std::iter::repeat_n(String::new(), 3);
            lines.push(line(LineKind::Detail, empty.chain(cells).chain([holds.to_owned()])));
        }
    }
    Grid { columns, lines }
}

fn line(kind: LineKind, cells: impl Iterator<Item = String>) -> Line {
    Line { kind, cells: cells.map(Cell::new).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reproduction::claim::{Claim, ClaimTest};
    use crate::reproduction::judged_claim::Seen;
    use crate::reproduction::steps::Basis;
    use crate::tables::formats::format::Format as _;
    use crate::tables::formats::markdown::Markdown;

    #[test]
    fn each_claim_has_its_readings_below_it() {
        let claim = Claim {
            paper: Paper::VehicleModel,
            place: "6".to_owned(),
            says: "It is fast.".to_owned(),
            printed: "23 against 13.5".to_owned(),
            test: ClaimTest::FrontSpheres,
        };
        let seen = |reading: &str, basis, holds| Seen {
            reading: reading.to_owned(),
            basis,
            numbers: "3 against 4".to_owned(),
            difference: "-1 (-2 to 0)".to_owned(),
            holds: Some(holds),
        };
        let readings = vec![seen("good faith", Basis::Text, false), seen("to the letter", Basis::Open, true)];
        let claims = [JudgedClaim::new(claim, readings, Some([3, 20]))];
        let table = ClaimsTable { claims: &claims, notes: &["A note.".to_owned()] };
        insta::assert_snapshot!(Markdown.text(&table), @r"
        **Of the claims (1) 1 hold with readings that the text leaves open.**

        **Börcs, Nagy, Baticz, Benedek: A Model-based Approach for Fast Vehicle Detection in Continuously Streamed Urban LIDAR Point Clouds, 2014 (VM)**

        | claim | place | printed | reading | here | difference (95 % interval) | verdict |
        | :-- | :-- | :-- | :-- | :-- | :-- | :-- |
        | It is fast. | 6 | 23 against 13.5 | good faith | 3 against 4 | -1 (-2 to 0) | holds with readings that the text leaves open: to the letter (3 of 20 settings) |
        |  |  |  | to the letter | 3 against 4 | -1 (-2 to 0) | holds so |

        - A note.
        ");
    }
}
