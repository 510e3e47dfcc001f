//! The edges of boxes: full where a side is seen, and dashed where none is.

use detector::OrientedBox;
use detector::detection::SeenSides;

/// A dash and the gap after it, in metres.
const DASH_M: f32 = 0.5;
const GAP_M: f32 = 0.3;

/// A straight line from end to end in metres.
pub type Line = [[f32; 3]; 2];

/// The lines that a box is drawn with: its edges at sides that are seen, then dashes along the others.
pub fn box_edges(drawn: &OrientedBox, seen: SeenSides) -> Vec<Line> {
    // Counter-clockwise from front left, so that side `k` lies between corners `k` and `k + 1`.
    let sides = [seen.left, seen.rear, seen.right, seen.front];
    let low_m = drawn.bottom_m();
    let high_m = low_m.map(|[x_m, y_m, z_m]| [x_m, y_m, z_m + drawn.length_width_height_m[2]]);
    let mut full = Vec::new();
    let mut dashed = Vec::new();
    for side in 0..4 {
        let (next, before) = ((side + 1) % 4, (side + 3) % 4);
        let around = if sides[side] { &mut full } else { &mut dashed };
        around.extend([[low_m[side], low_m[next]], [high_m[side], high_m[next]]]);
        let upright = if sides[side] || sides[before] { &mut full } else { &mut dashed };
        upright.push([low_m[side], high_m[side]]);
    }
    full.extend(dashed.into_iter().flat_map(dashes));
    full
}

/// Dashes along a line. The last one may be shorter.
fn dashes([from, to]: Line) -> impl Iterator<Item = Line> {
    let step: [f32; 3] = std::array::from_fn(|axis| to[axis] - from[axis]);
    let length_m = step.iter().map(|it| it * it).sum::<f32>().sqrt();
    let at = move |along_m: f32| std::array::from_fn(|axis| from[axis] + along_m / length_m * step[axis]);
    let n_dashes = (length_m / (DASH_M + GAP_M)).ceil() as usize;
    (0..n_dashes).map(move |dash| {
        let start_m = dash as f32 * (DASH_M + GAP_M);
        [at(start_m), at((start_m + DASH_M).min(length_m))]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAR: OrientedBox =
        OrientedBox { center_m: [10.0, 0.0, 0.0], length_width_height_m: [4.0, 2.0, 1.5], yaw_rad: 0.0 };

    fn length_m([from, to]: Line) -> f32 {
        (0..3).map(|axis| (to[axis] - from[axis]).powi(2)).sum::<f32>().sqrt()
    }

    #[test]
    fn what_is_seen_from_behind_and_the_right_is_full() {
        let lines = box_edges(&CAR, SeenSides { rear: true, right: true, ..SeenSides::default() });
        let (full, dashed): (Vec<Line>, Vec<Line>) =
            lines.into_iter().partition(|it| length_m(*it) > DASH_M + 1e-4);
        // Two edges along the right side, two across the rear, three upright ones.
        assert_eq!(full.len(), 7);
        assert!(full.iter().flatten().all(|[x_m, y_m, _]| *x_m == 8.0 || *y_m == -1.0), "{full:?}");
        // Twice 4 m and twice 2 m around, 1.5 m upwards.
        assert_eq!(dashed.len(), 2 * 5 + 2 * 3 + 2);
    }

    #[test]
    fn a_box_of_which_every_side_is_seen_has_its_twelve_edges() {
        let lines = box_edges(&CAR, SeenSides { front: true, rear: true, left: true, right: true });
        assert_eq!(lines.len(), 12);
        let around_m: f32 = lines.into_iter().map(length_m).sum();
        assert!((around_m - 4.0 * (4.0 + 2.0 + 1.5)).abs() < 1e-4);
    }

    #[test]
    fn dashes_end_with_their_line() {
        let dashes: Vec<Line> = dashes([[0.0; 3], [0.0, 1.1, 0.0]]).collect();
        let ends: Vec<f32> = dashes.iter().flatten().map(|it| (it[1] * 100.0).round() / 100.0).collect();
        assert_eq!(ends, [0.0, 0.5, 0.8, 1.1]);
    }
}
