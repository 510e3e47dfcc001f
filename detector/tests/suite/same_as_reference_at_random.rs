//! The detector finds what the reference finds on random clouds, and on those at the edge of what a scan can be.

use detector::PointCloud;
use detector::params::HierarchicalParams;
use detector::params::paper::PaperParams;
use detector::segment::ground_segmentation::HeightOver;
use proptest::prelude::*;

use crate::drawn_street::SENSOR_HEIGHT_M;
use crate::reference::twins::{CompletionTwins, Twins};
use crate::same_as_reference::beyond_papers;

const EXTENT_M: f32 = 12.0;

/// Parameters for clouds of few points on a small grid.
fn params(cell_size_m: f32, xi: u32) -> PaperParams {
    let mut params = beyond_papers();
    params.grid.cell_size_m = cell_size_m;
    params.grid.xi = xi;
    params.grid.extent_m = EXTENT_M;
    params.ground.min_points = 2;
    params.terrain.min_points = 2;
    // So that some dense cells are near-empty.
    params.separation.low_density_share = 0.6;
    // Of four hundred points few clusters have as many as in a scan.
    params.cluster.min_points = 5;
    params
}

/// A coordinate on the border of a dense cell of 20 cm, or a hair beside it.
fn border_m() -> impl Strategy<Value = f32> {
    (-20_i8..20, -1_i8..=1).prop_map(|(step, ulps)| {
        let border_m = -EXTENT_M + (60.0 + f32::from(step)) * 0.2;
        match ulps {
            -1 => border_m.next_down(),
            0 => border_m,
            _ => border_m.next_up(),
        }
    })
}

fn position_m() -> impl Strategy<Value = [f32; 3]> {
    let height_m = || prop_oneof![-1.8_f32..-1.6, -1.5_f32..0.5, 0.5_f32..2.0];
    let wild = || {
        prop_oneof![Just(f32::NAN), Just(f32::INFINITY), Just(-f32::INFINITY), Just(EXTENT_M), -1e3_f32..1e3]
    };
    prop_oneof![
        40 => [-4.0_f32..4.0, -4.0_f32..4.0].prop_map(|[x, y]| [x, y, -1.7]),
        60 => (-4.0_f32..4.0, -4.0_f32..4.0, height_m()).prop_map(|(x, y, z)| [x, y, z]),
        20 => (border_m(), border_m(), height_m()).prop_map(|(x, y, z)| [x, y, z]),
        10 => (-EXTENT_M..EXTENT_M, -EXTENT_M..EXTENT_M, height_m()).prop_map(|(x, y, z)| [x, y, z]),
        2 => [wild(), wild(), wild()],
        2 => (wild(), -4.0_f32..4.0).prop_map(|(x, y)| [x, y, 0.0]),
        2 => (-4.0_f32..4.0, wild()).prop_map(|(x, z)| [x, x, z]),
    ]
}

/// Points in runs, as a sensor gives them: each is repeated with small steps upward and sideways.
fn cloud(max_seeds: usize) -> impl Strategy<Value = PointCloud> {
    prop::collection::vec((position_m(), 1_u8..9, -0.1_f32..0.1), 0..max_seeds).prop_map(|seeds| {
        let runs = seeds.into_iter().flat_map(|([x, y, z], n, step_m)| {
            (0..n).map(move |idx| {
                let moved_m = f32::from(idx) * step_m;
                [x + moved_m, y - 0.3 * moved_m, z + 0.5 * moved_m]
            })
        });
        runs.collect()
    })
}

proptest! {
    #[test]
    fn on_random_clouds_one_after_the_other(
        clouds in prop::collection::vec(cloud(400), 1..4),
        cell_size_m in prop_oneof![Just(0.6_f32), 0.3_f32..1.5],
        xi in prop_oneof![Just(3_u32), 1_u32..=8],
        is_whole in prop::bool::weighted(0.8),
        is_printed in any::<bool>(),
    ) {
        let mut params = params(cell_size_m, xi);
        params.terrain.enabled = is_whole;
        params.separation.enabled = is_whole;
        if is_printed {
            params.ground.fewer_far_away = false;
            params.ground.low_itself = false;
            params.ground.tall_over = HeightOver::LevelRoad;
            params.walls.as_printed = true;
            params.foreground.clearance_m = f32::NEG_INFINITY;
        }
        let mut twins = Twins::new(params, SENSOR_HEIGHT_M);
        for cloud in &clouds {
            twins.check(cloud, "a random cloud");
        }
    }

    #[test]
    fn completed_objects_on_random_clouds(clouds in prop::collection::vec(cloud(400), 1..4)) {
        let mut params = HierarchicalParams::shipped();
        params.grid.extent_m = EXTENT_M;
        params.cluster.min_points = 5;
        let mut twins = CompletionTwins::new(params, SENSOR_HEIGHT_M);
        for cloud in &clouds {
            twins.check(cloud, "a random cloud");
        }
    }

    #[test]
    fn on_all_points_in_one_cell(
        offsets_m in prop::collection::vec([0.0_f32..0.6, 0.0_f32..0.6, -1.4_f32..0.6], 1..600)
    ) {
        let cloud = offsets_m.iter().map(|&[x, y, z]| [3.0 + x, -3.0 + y, z]).collect();
        Twins::new(params(0.6, 3), SENSOR_HEIGHT_M).check(&cloud, "one cell");
    }

    #[test]
    fn on_one_point(position_m in position_m()) {
        let mut params = params(0.6, 3);
        params.ground.min_points = 1;
        params.cluster.min_points = 1;
        let n_objects = Twins::new(params, SENSOR_HEIGHT_M).check(&[position_m].into_iter().collect(), "one point");
        prop_assert!(n_objects <= 1);
    }
}

#[test]
fn random_clouds_have_objects_and_gaps() {
    use proptest::strategy::ValueTree;
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let mut twins = Twins::new(params(0.6, 3), SENSOR_HEIGHT_M);
    let n_objects: usize = (0..20)
        .map(|_| {
            let cloud = cloud(400).new_tree(&mut runner).expect("a cloud").current();
            twins.check(&cloud, "a random cloud")
        })
        .sum();
    assert!(n_objects > 20, "{n_objects} objects in 20 clouds test little");
}
