//! Where points lie in the frames of labelled boxes, small enough for a manifest.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::numbers::box_points::{Across, BoxPoints};
use crate::vocabulary::class::AnnotationClass;

/// Number of cells of [`CELL_M`](crate::numbers::box_points::CELL_M) that views reach from the centre, along and across.
const REACH: [i32; 2] = [26, 12];
/// Digit of the fullest cells; each lower one stands for half as many points.
const FULLEST: u32 = 9;

/// All boxes of the most frequent class of vehicles, laid over one another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SeenLabels {
    /// The class.
    pub class: AnnotationClass,
    /// How many boxes there are.
    pub n_boxes: usize,
    /// Mean length, width and height of the boxes, in metres.
    pub length_width_height_m: [f64; 3],
    /// From above, the left on top and the front to the right: a digit for each cell of 0.15 m, 9 for the fullest, a lower
    /// one for half as many points each time, a dot for none.
    pub above: Vec<String>,
    /// The same from the side, without what is far beside the box.
    pub side: Vec<String>,
}

impl SeenLabels {
    /// Packs the views from above and from the side.
    pub fn of([above, side]: [BoxPoints; 2]) -> Self {
        let [length_m, width_m] = above.length_width_m;
        let round = |it: f64| (it * 100.0).round() / 100.0;
        Self {
            class: above.class,
            n_boxes: above.n_vehicles,
            length_width_height_m: [length_m, width_m, side.length_width_m[1]].map(round),
            above: lines(&above),
            side: lines(&side),
        }
    }

    /// The views from above and from the side, to be drawn.
    pub fn views(&self) -> [BoxPoints; 2] {
        let [length_m, width_m, height_m] = self.length_width_height_m;
        let views = [(Across::Left, width_m, &self.above), (Across::Up, height_m, &self.side)];
        views.map(|(across, across_m, lines)| BoxPoints {
            class: self.class,
            frame: "annotated box",
            n_vehicles: self.n_boxes,
            across,
            length_width_m: [length_m, across_m],
            shares: shares(lines),
        })
    }
}

fn lines(points: &BoxPoints) -> Vec<String> {
    let [along, across] = REACH;
    let cells = || (-across..across).rev().flat_map(|y| (-along..along).map(move |x| [x, y]));
    let share = |cell: &[i32; 2]| points.shares.get(cell).copied().unwrap_or(0.0);
    let fullest = cells().map(|it| share(&it)).fold(0.0, f64::max);
    let digit = |cell: [i32; 2]| {
        let below = (-(share(&cell) / fullest).log2()).floor();
        let digit = f64::from(FULLEST) - below;
        if digit >= 1.0 { char::from_digit(digit as u32, 10).unwrap_or('.') } else { '.' }
    };
    let digits: Vec<char> = cells().map(digit).collect();
    digits.chunks(2 * along as usize).map(|it| it.iter().collect()).collect()
}

fn shares(lines: &[String]) -> BTreeMap<[i32; 2], f64> {
    let [along, across] = REACH;
    let of_line = |(y, line): (i32, &String)| {
        let digits = (-along..along).zip(line.chars()).filter_map(|(x, it)| Some((x, it.to_digit(10)?)));
        digits.map(|(x, it)| ([x, y], 2_f64.powi(it as i32 - FULLEST as i32))).collect::<Vec<_>>()
    };
    (-across..across).rev().zip(lines).flat_map(of_line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::box_points::FramedPoints;

    #[test]
    fn what_is_drawn_is_what_was_seen() {
        let positions_m = [[2.0, 0.1], [2.0, 0.1], [2.0, 0.1], [2.0, 0.1], [-1.9, -0.8], [90.0, 0.0]];
        let framed = |across_m| FramedPoints { length_width_m: [4.0, across_m], positions_m: &positions_m };
        let view = |across, across_m| {
            BoxPoints::of(AnnotationClass::Car, "annotated box", [framed(across_m)].into_iter())
                .seen_across(across)
        };
        let seen = SeenLabels::of([view(Across::Left, 1.8), view(Across::Up, 1.5)]);
        assert_eq!(seen.length_width_height_m, [4.0, 1.8, 1.5]);
        assert_eq!((seen.above.len(), seen.above[0].len()), (24, 52));
        assert_eq!(seen.above[11].find('9'), Some(26 + 13), "{seen:#?}");
        let [above, side] = seen.views();
        assert_eq!(above.shares.iter().collect::<Vec<_>>(), [(&[-13, -6], &0.25), (&[13, 0], &1.0)]);
        assert_eq!((side.across, side.length_width_m), (Across::Up, [4.0, 1.5]));
        assert_eq!(SeenLabels::of([above, side]), seen);
    }
}
