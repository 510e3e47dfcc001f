//! Rows whose numbers can be computed in the head.

use proptest::prelude::*;

use super::drawn_scans::{DrawnScans, N_LANES};
use super::protocol_tally::{ProtocolQuestion, ProtocolTally};
use super::under_protocol::UnderProtocol;
use crate::rows::ranked_box_row::{BoxKind, BoxState, PairErrors, RankedBox, RankedBoxRow};
use crate::rows::scan_name::ScanName;
use crate::vocabulary::protocol::Protocol;

/// An annotation of `class` in scan `scan`.
pub(super) fn labelled(protocol: Protocol, scan: u32, class: &'static str) -> RankedBoxRow {
    RankedBoxRow {
        scan: ScanName { dataset: "street".to_owned(), sequence: "0000".to_owned(), scan },
        detector: "mine".to_owned(),
        protocol,
        ranked_box: RankedBox {
            id: 0,
            name: class.to_owned(),
            class,
            state: BoxState::Counts,
            center_m: [10.0, 0.0, 0.0],
            length_width_height_m: [4.0, 2.0, 1.5],
            yaw_rad: 0.0,
            velocity_m_per_s: Some([0.0, 0.0]),
            attribute: None,
            n_points: Some(7),
            kind: BoxKind::Annotation,
        },
    }
}

/// A detection, which finds an annotation at all distances, half a metre off and turned by 0.3, or none.
pub(super) fn found(
    protocol: Protocol,
    scan: u32,
    id: u32,
    class: &'static str,
    score: f64,
    annotation: Option<u32>,
) -> RankedBoxRow {
    let errors = PairErrors {
        translation_m: 0.5,
        scale: 0.2,
        orientation_rad: 0.3,
        velocity_m_per_s: Some(2.0),
        attribute: None,
    };
    let mut row = labelled(protocol, scan, class);
    row.ranked_box.id = id;
    let pairs = [annotation; 4];
    row.ranked_box.kind = BoxKind::Detection { score, pairs, errors: annotation.map(|_| errors) };
    row
}

/// The ranking right, false, right, on two annotations of `class` in two scans.
pub(super) fn right_false_right(protocol: Protocol, class: &'static str) -> Vec<RankedBoxRow> {
    vec![
        labelled(protocol, 0, class),
        labelled(protocol, 1, class),
        found(protocol, 0, 0, class, 0.9, Some(0)),
        found(protocol, 0, 1, class, 0.8, None),
        found(protocol, 1, 0, class, 0.7, Some(0)),
    ]
}

/// Result of `look` at rows under their protocol.
fn under_protocol<T>(rows: &[RankedBoxRow], look: impl FnOnce(&dyn UnderProtocol) -> T) -> T {
    let mut tally = ProtocolTally::default();
    for row in rows {
        tally.add_ranked_box(row);
    }
    let scans = DrawnScans::undrawn(rows.iter().map(|it| it.scan.clone()).collect());
    let question = ProtocolQuestion { protocol: rows[0].protocol, detector: "mine" };
    look(&*tally.rows(question, &scans).expect("there are rows"))
}

/// The number called `metric` of `class`, where scan *i* is there `times[i]` times.
pub(super) fn number(rows: &[RankedBoxRow], times: &[u16], class: &str, metric: &str) -> Option<f64> {
    under_protocol(rows, |rows| {
        let index = rows.metrics().iter().position(|it| it.class == class && it.id == metric);
        rows.values(times)[index.unwrap_or_else(|| panic!("no {metric} of {class}"))]
    })
}

/// How often each of `n` scans occurs in several draws.
pub(super) fn any_times(n: usize) -> impl Strategy<Value = Vec<[u16; N_LANES]>> {
    prop::collection::vec(prop::array::uniform8(0..4_u16), n)
}

/// Checks that several draws at once have the values of each draw by itself.
#[track_caller]
pub(super) fn check_draws(rows: &[RankedBoxRow], times: &[[u16; N_LANES]]) {
    under_protocol(rows, |rows| {
        let of_draw = |draw| times.iter().map(|it| it[draw]).collect::<Vec<_>>();
        let of_each: Vec<_> = (0..N_LANES).map(|draw| rows.values(&of_draw(draw))).collect();
        let at_once: Vec<[f64; N_LANES]> = times.iter().map(|it| it.map(f64::from)).collect();
        assert_eq!(rows.values_of_draws(&at_once), of_each);
    });
}
