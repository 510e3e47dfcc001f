//! The tree of the frames of a recording at one moment.

use std::collections::BTreeMap;

use nalgebra::Isometry3;

use super::foxglove_messages::{FrameTransform, FrameTransforms, decode};
use super::ros_messages::{StampedTransform, tf_message};
use super::topics::MessageKind;

/// A chain of frames longer than this goes in a circle.
const MAX_DEPTH: usize = 64;

/// The transforms in `bytes`, a message of this kind in the encoding of its channel. Errors are the rest of a sentence about
/// the file.
pub fn transforms_of_message(
    kind: MessageKind,
    encoding: &str,
    bytes: &[u8],
) -> Result<Vec<StampedTransform>, String> {
    match kind {
        MessageKind::RosTransforms => tf_message(bytes),
        MessageKind::FoxgloveTransform => Ok(vec![decode::<FrameTransform>(encoding, bytes)?.stamped()?]),
        _ => {
            let all: FrameTransforms = decode(encoding, bytes)?;
            all.transforms.iter().map(FrameTransform::stamped).collect()
        }
    }
}

/// The parent of every frame, and the frame's pose in it.
#[derive(Debug, Clone, Default)]
pub struct FrameTree {
    parents: BTreeMap<String, (String, Isometry3<f64>)>,
}

impl FrameTree {
    /// The tree at `time_ns`, from `transforms` in any order. For each frame it interpolates between the last transform
    /// before and the first one after; before the first and after the last, it takes the nearest.
    pub fn at(time_ns: u64, transforms: impl IntoIterator<Item = StampedTransform>) -> Self {
        let mut around: BTreeMap<String, [Option<StampedTransform>; 2]> = BTreeMap::new();
        for transform in transforms {
            let [before, after] = around.entry(transform.child.clone()).or_default();
            if transform.stamp_ns <= time_ns {
                if before.as_ref().is_none_or(|it| it.stamp_ns <= transform.stamp_ns) {
                    *before = Some(transform);
                }
            } else if after.as_ref().is_none_or(|it| it.stamp_ns > transform.stamp_ns) {
                *after = Some(transform);
            }
        }
        let parent = |around: [Option<StampedTransform>; 2]| match around {
            [Some(before), Some(after)] if before.parent == after.parent => {
                let n_between = (after.stamp_ns - before.stamp_ns) as f64;
                let share = (time_ns - before.stamp_ns) as f64 / n_between;
                let between = before.parent_from_child.try_lerp_slerp(&after.parent_from_child, share, 1e-9);
                Some((before.parent, between.unwrap_or(before.parent_from_child)))
            }
            [Some(it), _] | [None, Some(it)] => Some((it.parent, it.parent_from_child)),
            [None, None] => None,
        };
        let parents = around.into_iter().filter_map(|(child, around)| Some((child, parent(around)?)));
        Self { parents: parents.collect() }
    }

    /// From coordinates of `frame` to those of its outermost parent.
    pub fn root_from(&self, frame: &str) -> Isometry3<f64> {
        self.ancestors(frame).pop().map_or_else(Isometry3::identity, |(_, transform)| transform)
    }

    /// From coordinates of `from` to those of `to`; `None` if the frames are not connected.
    pub fn to_from(&self, to: &str, from: &str) -> Option<Isometry3<f64>> {
        let of_to = self.ancestors(to);
        self.ancestors(from).into_iter().find_map(|(common, common_from)| {
            let (_, common_to) = of_to.iter().find(|(name, _)| *name == common)?;
            Some(common_to.inverse() * common_from)
        })
    }

    /// `frame` and all its ancestors, with the transforms from `frame` to them.
    fn ancestors<'a>(&'a self, frame: &'a str) -> Vec<(&'a str, Isometry3<f64>)> {
        let mut ancestors = vec![(frame, Isometry3::identity())];
        while ancestors.len() < MAX_DEPTH {
            let Some((last, last_from_frame)) = ancestors.last() else { break };
            let Some((parent, parent_from_last)) = self.parents.get(*last) else { break };
            ancestors.push((parent, parent_from_last * last_from_frame));
        }
        ancestors
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shift(stamp_ns: u64, parent: &str, child: &str, x_m: f64) -> StampedTransform {
        let parent_from_child = Isometry3::translation(x_m, 0.0, 0.0);
        StampedTransform { stamp_ns, parent: parent.to_owned(), child: child.to_owned(), parent_from_child }
    }

    #[track_caller]
    fn check(tree: &FrameTree, to: &str, from: &str, expected_x_m: Option<f64>) {
        let found = tree.to_from(to, from).map(|it| it.translation.x);
        assert_eq!(found.is_some(), expected_x_m.is_some(), "{found:?}");
        assert!((found.unwrap_or_default() - expected_x_m.unwrap_or_default()).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn frames_are_chained_over_what_they_have_in_common() {
        let tree = FrameTree::at(
            0,
            [shift(0, "map", "car", 10.0), shift(0, "car", "lidar", 1.0), shift(0, "map", "sign", 15.0)],
        );
        check(&tree, "lidar", "sign", Some(4.0));
        check(&tree, "car", "lidar", Some(1.0));
        check(&tree, "lidar", "lidar", Some(0.0));
        check(&tree, "lidar", "moon", None);
        assert!((tree.root_from("lidar").translation.x - 11.0).abs() < 1e-9);
    }

    #[test]
    fn between_two_moments_frames_are_between() {
        let moving =
            [shift(300, "map", "car", 3.0), shift(100, "map", "car", 1.0), shift(200, "map", "car", 2.0)];
        for (time_ns, expected_x_m) in [(0, 1.0), (100, 1.0), (150, 1.5), (275, 2.75), (900, 3.0)] {
            check(&FrameTree::at(time_ns, moving.clone()), "map", "car", Some(expected_x_m));
        }
    }

    #[test]
    fn a_circle_ends() {
        let tree = FrameTree::at(0, [shift(0, "a", "b", 1.0), shift(0, "b", "a", 1.0)]);
        check(&tree, "a", "moon", None);
        assert!(tree.root_from("a").translation.x.is_finite());
    }
}
