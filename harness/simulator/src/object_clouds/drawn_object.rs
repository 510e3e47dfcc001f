//! An object drawn by its number, and the random streams for it and its scans.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use reports::vocabulary::partial_class::PartialClass;

use super::object_kind::any_object;
use crate::object_shape::ObjectShape;

/// Which object of a simulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ObjectNumber {
    /// Objects of one seed have nothing in common with those of another.
    pub seed: u64,
    /// Its class.
    pub class: PartialClass,
    /// Its number among those of its class.
    pub number: u32,
}

/// An object as it stands in the world, its middle above the origin.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnObject {
    /// Its form.
    pub shape: ObjectShape,
    /// How it is turned about the vertical, in radians.
    pub yaw_rad: f32,
}

/// Use of random numbers; each has a stream of its own, so that no use disturbs another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StreamUse {
    /// The form of the object.
    Form,
    /// Where a sensor stands, or how a vehicle drives.
    Viewpoint,
    /// The errors of the beams of a sensor.
    Beams,
    /// The errors of the poses of a vehicle.
    Drift,
    /// The pulses of a beam in one of many scans.
    Pulses {
        /// Which scan.
        scan: u32,
        /// Which beam of it.
        beam: u32,
    },
}

impl ObjectNumber {
    /// The object.
    pub fn draw(self) -> DrawnObject {
        let mut rng = self.random_stream(StreamUse::Form);
        let shape = any_object(self.class, &mut rng);
        DrawnObject { shape, yaw_rad: rng.random_range(-std::f32::consts::PI..std::f32::consts::PI) }
    }

    /// The random stream for `stream_use`.
    pub fn random_stream(self, stream_use: StreamUse) -> ChaCha8Rng {
        let class_idx = PartialClass::ALL.iter().position(|it| *it == self.class).unwrap_or_default();
        let mut key = [0; 32];
        key[..8].copy_from_slice(&self.seed.to_le_bytes());
        key[8..12].copy_from_slice(&self.number.to_le_bytes());
        key[12] = class_idx as u8;
        // Keeps these streams apart from those of streets.
        key[16..23].copy_from_slice(b"objects");
        let mut rng = ChaCha8Rng::from_seed(key);
        rng.set_stream(match stream_use {
            StreamUse::Form => 0,
            StreamUse::Viewpoint => 1,
            StreamUse::Beams => 2,
            StreamUse::Drift => 3,
            StreamUse::Pulses { scan, beam } => 1 << 48 | u64::from(scan) << 16 | u64::from(beam),
        });
        rng
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn objects_of_other_numbers_classes_and_seeds_are_others() {
        let mut drawn = BTreeSet::new();
        for class in PartialClass::LEARNT {
            for (seed, number) in [(1, 0), (1, 1), (2, 0), (2, 1)] {
                let object = ObjectNumber { seed, class, number }.draw();
                assert_eq!(object, ObjectNumber { seed, class, number }.draw());
                assert!(drawn.insert(format!("{object:?}")), "{class} {seed} {number}");
            }
        }
    }

    #[test]
    fn uses_of_dice_do_not_disturb_each_other() {
        use rand::Rng as _;
        let object = ObjectNumber { seed: 3, class: PartialClass::Tree, number: 7 };
        let pulses = |scan, beam| StreamUse::Pulses { scan, beam };
        let uses = [
            StreamUse::Form,
            StreamUse::Viewpoint,
            StreamUse::Beams,
            StreamUse::Drift,
            pulses(0, 0),
            pulses(0, 1),
            pulses(1, 0),
            pulses(70_000, 0),
        ];
        let first: BTreeSet<u64> = uses.iter().map(|it| object.random_stream(*it).next_u64()).collect();
        assert_eq!(first.len(), uses.len());
    }
}
