//! The edges of boxes: full where a side is seen, and dashed where none is.

use detector::OrientedBox;
use detector::detection::SeenSides;

use crate::rounding::Rounding;

/// A dash and the gap after it, in metres.
const DASH_M: f32 = 0.5;
const GAP_M: f32 = 0.3;
/// Finer than a line is wide.
const ROUNDING_M: f32 = 0.01;

/// Positions in metres that a line goes through.
pub type Strip = Vec<[f32; 3]>;

/// The lines that a box is drawn with: one around each side that is seen, then dashes along the other edges; two if nobody says
/// what is seen.
pub fn box_edges(drawn: &OrientedBox, seen: Option<SeenSides>) -> Vec<Strip> {
    let rounding = Rounding::finer_than(ROUNDING_M);
    let low_m = drawn.bottom_m();
    let high_m = low_m.map(|[x_m, y_m, z_m]| [x_m, y_m, z_m + drawn.length_width_height_m[2]]);
    let (low_m, high_m) = (low_m.map(|it| rounding.position_m(it)), high_m.map(|it| rounding.position_m(it)));
    let Some(seen) = seen else {
        let [a, b, c, d] = low_m;
        let [e, f, g, h] = high_m;
        // All edges, some twice; and that of the front again, since no viewer shows the label of the only line of an entity.
        return vec![vec![a, b, c, d, a, e, f, b, f, g, c, g, h, d, h, e], vec![d, a]];
    };
    // Counter-clockwise from front left, so that side `k` lies between corners `k` and `k + 1`.
    let sides = [seen.left, seen.rear, seen.right, seen.front];
    let mut strips = Vec::new();
    let mut dashed = Vec::new();
    for side in 0..4 {
        let (next, before) = ((side + 1) % 4, (side + 3) % 4);
        if sides[side] {
            strips.push(vec![low_m[side], low_m[next], high_m[next], high_m[side], low_m[side]]);
        } else {
            dashed.extend([[low_m[side], low_m[next]], [high_m[side], high_m[next]]]);
        }
        if !sides[side] && !sides[before] {
            dashed.push([low_m[side], high_m[side]]);
        }
    }
    strips.extend(dashed.into_iter().flat_map(|it| dashes(it, rounding)));
    strips
}

/// Dashes along the straight line between two ends. The last one may be shorter.
fn dashes([from, to]: [[f32; 3]; 2], rounding: Rounding) -> impl Iterator<Item = Strip> {
    let step: [f32; 3] = std::array::from_fn(|axis| to[axis] - from[axis]);
    let length_m = step.iter().map(|it| it * it).sum::<f32>().sqrt();
    let at = move |along_m: f32| std::array::from_fn(|axis| from[axis] + along_m / length_m * step[axis]);
    let n_dashes = (length_m / (DASH_M + GAP_M)).ceil() as usize;
    (0..n_dashes).map(move |dash| {
        let start_m = dash as f32 * (DASH_M + GAP_M);
        [at(start_m), at((start_m + DASH_M).min(length_m))].map(|it| rounding.position_m(it)).to_vec()
    })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    const CAR: OrientedBox =
        OrientedBox { center_m: [10.0, 0.0, 0.0], length_width_height_m: [4.0, 2.0, 1.5], yaw_rad: 0.0 };

    #[test]
    fn what_is_seen_from_behind_and_the_right_is_full() {
        let lines = box_edges(&CAR, Some(SeenSides { rear: true, right: true, ..SeenSides::default() }));
        let (full, dashed): (Vec<Strip>, Vec<Strip>) = lines.into_iter().partition(|it| it.len() > 2);
        let [rear, right] = &full[..] else { panic!("{full:?}") };
        assert!(rear.iter().all(|[x_m, ..]| *x_m == 8.0), "{rear:?}");
        assert!(right.iter().all(|[_, y_m, _]| *y_m == -1.0), "{right:?}");
        // Twice 4 m and twice 2 m around, 1.5 m upwards.
        assert_eq!(dashed.len(), 2 * 5 + 2 * 3 + 2);
    }

    #[test]
    fn a_box_has_its_twelve_edges() {
        let all_seen = SeenSides { front: true, rear: true, left: true, right: true };
        let bits = |it: [f32; 3]| it.map(f32::to_bits);
        let edge = |it: &[[f32; 3]]| BTreeSet::from([bits(it[0]), bits(it[1])]);
        let edges = |seen| -> BTreeSet<_> {
            box_edges(&CAR, seen).iter().flat_map(|it| it.windows(2).map(edge).collect::<Vec<_>>()).collect()
        };
        assert_eq!(edges(Some(all_seen)).len(), 12);
        assert_eq!(edges(None), edges(Some(all_seen)));
    }

    #[test]
    fn dashes_end_with_their_line() {
        let dashes: Vec<Strip> = dashes([[0.0; 3], [0.0, 1.1, 0.0]], Rounding::default()).collect();
        let ends: Vec<f32> = dashes.iter().flatten().map(|it| (it[1] * 100.0).round() / 100.0).collect();
        assert_eq!(ends, [0.0, 0.5, 0.8, 1.1]);
    }
}
