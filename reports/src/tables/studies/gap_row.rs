//! `gaps.csv`: one row for every detector, kind of pair, layout, range and gap.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::fixed_decimals::Fixed;
use crate::numbers::gap_curve::GapBin;

row! {
    /// One bin, with what its share is made of.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct GapRow {
        data: String,
        detector: String,
        pair: String,
        layout: String,
        range_from_m: Fixed<1>,
        range_to_m: Fixed<1>,
        gap_m: Fixed<2>,
        n_pairs: u64,
        n_seen: u64,
        n_separated: u64,
        n_joined: u64,
        separated: Option<Fixed<4>>,
        separated_low: Option<Fixed<4>>,
        separated_high: Option<Fixed<4>>,
    }
}

impl GapRow {
    /// The row of `bin`, which was simulated.
    pub fn simulated(bin: &GapBin) -> Self {
        let within = bin.counts.separated_within();
        Self {
            data: "simulated".to_owned(),
            detector: bin.detector.clone(),
            pair: bin.pair.clone(),
            layout: bin.layout.clone(),
            range_from_m: Fixed(bin.range_m[0]),
            range_to_m: Fixed(bin.range_m[1]),
            gap_m: Fixed(bin.gap_m),
            n_pairs: bin.counts.n_pairs,
            n_seen: bin.counts.n_seen,
            n_separated: bin.counts.n_separated,
            n_joined: bin.counts.n_joined,
            separated: bin.counts.separated().map(Fixed),
            separated_low: within.map(|it| Fixed(it[0])),
            separated_high: within.map(|it| Fixed(it[1])),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::csv_rows::tests::{csv_text, rows_of};
    use crate::numbers::gap_curve::tests::bin;

    #[test]
    fn a_share_of_nothing_is_left_empty() {
        let mut unseen = bin("grid", "cars", true, 0.3, 0);
        unseen.counts.n_seen = 0;
        unseen.counts.n_joined = 0;
        let rows = [bin("grid", "cars", false, 0.2, 7), unseen].map(|it| GapRow::simulated(&it));
        let text = csv_text(&rows);
        insta::assert_snapshot!(text, @r"
        data,detector,pair,layout,range_from_m,range_to_m,gap_m,n_pairs,n_seen,n_separated,n_joined,separated,separated_low,separated_high
        simulated,grid,cars,beside,5.0,10.0,0.20,12,10,7,3,0.7000,0.3968,0.8922
        simulated,grid,cars,beside,10.0,20.0,0.30,12,0,0,0,,,
        ");
        assert_eq!(rows_of::<GapRow>(&text).unwrap().len(), rows.len());
    }
}
