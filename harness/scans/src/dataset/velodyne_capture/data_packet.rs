//! The data packets: twelve blocks of 32 measurements each, and the points of these measurements.
//!
//! If packets hold two returns of every laser, the last is taken.

use std::ops::Range;

use super::calibration_file::DISTANCE_STEP_M;
use super::laser_table::{Laser, VelodyneModel};
use crate::dataset::positioned_points::PositionedPoints;

/// The port that data packets go to.
pub const DATA_PORT: u16 = 2368;

/// Size of a data packet in bytes.
pub const N_PACKET_BYTES: usize = 1206;

/// Number of blocks in a packet.
pub const N_BLOCKS: usize = 12;

/// A whole turn in hundredths of a degree.
pub const FULL_TURN: u16 = 36_000;

const N_BLOCK_BYTES: usize = 100;
const N_MEASUREMENTS: usize = 32;

/// The first bytes of a block: of lasers 0 to 31, and of 32 to 63.
const FIRST_BANK: u16 = 0xeeff;
const SECOND_BANK: u16 = 0xddff;

/// The last bytes of a packet: number of returns, and sensor; not so for the HDL-64E.
const DUAL_RETURN: u8 = 0x39;
const PRODUCTS: [(u8, VelodyneModel); 2] = [(0x21, VelodyneModel::Hdl32e), (0x22, VelodyneModel::Vlp16)];

/// The greatest step from one column of lasers to the next, in hundredths of a degree; a larger step is a gap.
pub const MAX_STEP: u16 = 300;

/// The two distances at which lasers were calibrated, the near one across and along, in metres.
const FAR_M: f32 = 25.04;
const NEAR_M: [f32; 2] = [2.40, 1.93];

/// The direction in which the head turns, seen from above.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rotation {
    /// Azimuths ascend.
    Clockwise,
    /// Azimuths descend.
    CounterClockwise,
}

impl Rotation {
    /// How far the head turns from one azimuth to another, in hundredths of a degree, below a whole turn.
    pub fn from(self, azimuth: u16, to: u16) -> u16 {
        let [from, to] = match self {
            Self::Clockwise => [azimuth, to],
            Self::CounterClockwise => [to, azimuth],
        };
        ((u32::from(to) + u32::from(FULL_TURN) - u32::from(from)) % u32::from(FULL_TURN)) as u16
    }

    /// A step in hundredths of a degree as a change of the azimuth.
    fn signed(self, step: u16) -> f32 {
        match self {
            Self::Clockwise => f32::from(step),
            Self::CounterClockwise => -f32::from(step),
        }
    }
}

/// Laser and time of a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Firing {
    /// Its index in the table of lasers.
    pub laser_idx: usize,
    /// Microseconds after the first lasers of the packet.
    pub micros: f32,
}

/// A data packet.
#[derive(Debug, Clone, Copy)]
pub struct DataPacket<'a> {
    bytes: &'a [u8; N_PACKET_BYTES],
    model: VelodyneModel,
    is_dual: bool,
    rotation: Rotation,
}

impl<'a> DataPacket<'a> {
    /// The packet in `bytes`. Errors are the rest of a sentence about the file.
    pub fn parse(bytes: &'a [u8; N_PACKET_BYTES]) -> Result<Self, String> {
        let flag = |block: usize| {
            u16::from_le_bytes([bytes[block * N_BLOCK_BYTES], bytes[block * N_BLOCK_BYTES + 1]])
        };
        let flags: [u16; N_BLOCKS] = std::array::from_fn(flag);
        if let Some(flag) = flags.iter().find(|it| ![FIRST_BANK, SECOND_BANK].contains(it)) {
            return Err(format!("has a packet with a block that begins with {flag:#06x}"));
        }
        let (returns, product) = (bytes[N_PACKET_BYTES - 2], bytes[N_PACKET_BYTES - 1]);
        let model = if flags.contains(&SECOND_BANK) {
            VelodyneModel::Hdl64e
        } else {
            let known = PRODUCTS.iter().find(|(known, _)| *known == product);
            let unknown = || format!("has packets of an unknown sensor, {product:#04x}");
            known.map(|(_, model)| *model).ok_or_else(unknown)?
        };
        let rotation = Rotation::Clockwise;
        let mut packet = Self { bytes, model, is_dual: returns == DUAL_RETURN, rotation };
        if model == VelodyneModel::Hdl64e {
            // The last bytes of this sensor have another meaning.
            packet.is_dual = packet.azimuth(0) == packet.azimuth(2);
        }
        match (0..N_BLOCKS).map(|block| packet.azimuth(block)).find(|it| *it >= FULL_TURN) {
            Some(azimuth) => Err(format!("has a packet with an azimuth of {azimuth} hundredths of a degree")),
            None => Ok(packet),
        }
    }

    /// The packet of a head that turns this way.
    pub fn turning(self, rotation: Rotation) -> Self {
        Self { rotation, ..self }
    }

    /// The azimuths of all blocks.
    pub fn azimuths(&self) -> [u16; N_BLOCKS] {
        std::array::from_fn(|block| self.azimuth(block))
    }

    /// The sensor that sent it.
    pub fn model(&self) -> VelodyneModel {
        self.model
    }

    /// The azimuth of a block, clockwise, in hundredths of a degree.
    pub fn azimuth(&self, block: usize) -> u16 {
        let at = block * N_BLOCK_BYTES + 2;
        u16::from_le_bytes([self.bytes[at], self.bytes[at + 1]])
    }

    /// Number of blocks with one azimuth.
    fn n_blocks_of_column(&self) -> usize {
        let n_banks = if self.model == VelodyneModel::Hdl64e { 2 } else { 1 };
        if self.is_dual { 2 * n_banks } else { n_banks }
    }

    /// Whether a block holds the returns that are taken: the last ones, which come first except in the HDL-64E.
    fn is_taken(&self, block: usize) -> bool {
        match (self.is_dual, self.model) {
            (false, _) => true,
            (true, VelodyneModel::Hdl64e) => block % 4 >= 2,
            (true, _) => block.is_multiple_of(2),
        }
    }

    /// Change of the azimuth from this column to the next.
    fn step(&self, block: usize) -> f32 {
        let n = self.n_blocks_of_column();
        let column = block / n;
        let last = (N_BLOCKS / n).saturating_sub(2);
        let step_of = |column: usize| {
            self.rotation.from(self.azimuth(column * n), self.azimuth((column + 1) % (N_BLOCKS / n) * n))
        };
        // The last column is followed by the next packet, and as wide as the one before. So is a column before a gap.
        let is_gap = |step: u16| (MAX_STEP + 1..FULL_TURN - MAX_STEP).contains(&step);
        let steps = [column.min(last), column.saturating_sub(1), 0, last].map(step_of);
        let step = steps.into_iter().find(|it| !is_gap(*it)).unwrap_or(0);
        if step > MAX_STEP { 0.0 } else { self.rotation.signed(step) }
    }

    /// The first block behind a gap of the field of view within the packet.
    pub fn block_after_gap(&self) -> Option<usize> {
        let is_after_gap = |block: &usize| {
            let step = self.rotation.from(self.azimuth(block - 1), self.azimuth(*block));
            (MAX_STEP + 1..FULL_TURN - MAX_STEP).contains(&step)
        };
        (1..N_BLOCKS).find(is_after_gap)
    }

    /// Microseconds from the first lasers of a packet to those of the next.
    pub fn duration_micros(&self) -> f32 {
        let [_, of_column] = self.micros_of(0);
        (N_BLOCKS / self.n_blocks_of_column()) as f32 * of_column
    }

    /// Time of its first lasers, in microseconds of an hour.
    pub fn micros_of_hour(&self) -> u32 {
        let [.., a, b, c, d, _, _] = *self.bytes;
        u32::from_le_bytes([a, b, c, d])
    }

    /// Appends the points of `blocks`, and their lasers and times. Measurements without a return give no point.
    pub fn append_points(
        &self,
        blocks: Range<usize>,
        lasers: &[Laser],
        points: &mut PositionedPoints,
        firings: &mut Vec<Firing>,
    ) -> Result<(), String> {
        for block in (blocks.start..blocks.end.min(N_BLOCKS)).filter(|it| self.is_taken(*it)) {
            let begin = block * N_BLOCK_BYTES;
            let is_second_bank = self.bytes[begin..begin + 2] == SECOND_BANK.to_le_bytes();
            let (azimuth, step) = (f32::from(self.azimuth(block)), self.step(block));
            let (measurements, _) = self.bytes[begin + 4..begin + N_BLOCK_BYTES].as_chunks::<3>();
            for (index, &[low, high, intensity]) in measurements.iter().enumerate().take(N_MEASUREMENTS) {
                let distance = u16::from_le_bytes([low, high]);
                let laser_idx = match self.model {
                    VelodyneModel::Vlp16 => index % 16,
                    VelodyneModel::Hdl32e => index,
                    VelodyneModel::Hdl64e => index + if is_second_bank { N_MEASUREMENTS } else { 0 },
                };
                if let (true, Some(laser)) = (distance > 0, lasers.get(laser_idx)) {
                    let hundredths = azimuth + step * self.share_of_step(index);
                    let azimuth_rad = (hundredths / 100.0).to_radians();
                    let position_m = position_m(laser, azimuth_rad, f32::from(distance) * DISTANCE_STEP_M);
                    points.push(position_m.map(f64::from), f32::from(intensity) / 255.0)?;
                    firings.push(Firing { laser_idx, micros: self.micros_after_first(block, index) });
                }
            }
        }
        Ok(())
    }

    /// Time of a laser within its column, as a share of the time from one column to the next.
    fn share_of_step(&self, index: usize) -> f32 {
        let [micros, of_column] = self.micros_of(index);
        micros / of_column
    }

    /// Microseconds from the first lasers of the packet to this one.
    fn micros_after_first(&self, block: usize, index: usize) -> f32 {
        let [micros, of_column] = self.micros_of(index);
        (block / self.n_blocks_of_column()) as f32 * of_column + micros
    }

    /// Microseconds from the start of a column to a laser, and to the next column.
    fn micros_of(&self, index: usize) -> [f32; 2] {
        match self.model {
            VelodyneModel::Vlp16 => [55.296 * (index / 16) as f32 + 2.304 * (index % 16) as f32, 110.592],
            VelodyneModel::Hdl32e => [1.152 * index as f32, 46.08],
            VelodyneModel::Hdl64e => [6.0 * (index / 4) as f32 + 1.2 * (index % 4) as f32, 48.0],
        }
    }
}

/// The position of a return, with x forward and y left; the azimuth is clockwise from forward.
fn position_m(laser: &Laser, azimuth_rad: f32, measured_m: f32) -> [f32; 3] {
    let (sin_vertical, cos_vertical) = laser.vertical_rad.sin_cos();
    let (sin, cos) = (azimuth_rad - laser.rotation_rad).sin_cos();
    let (horizontal_m, vertical_m) = (laser.horizontal_offset_m, laser.vertical_offset_m);
    let distance_m = measured_m + laser.distance_m;
    let right_m = |along_m: f32| along_m * sin - horizontal_m * cos;
    let forward_m = |along_m: f32| along_m * cos + horizontal_m * sin;
    let along_m = |distance_m: f32| distance_m * cos_vertical - vertical_m * sin_vertical;
    let [far_right_m, far_forward_m] = match laser.distance_nearby_m {
        None => [distance_m; 2],
        Some(nearby_m) => {
            let seen_m = [right_m(along_m(distance_m)).abs(), forward_m(along_m(distance_m)).abs()];
            std::array::from_fn(|axis| {
                // Interpolated between the two distances; beyond them, as at the nearer one.
                let share = ((seen_m[axis] - NEAR_M[axis]) / (FAR_M - NEAR_M[axis])).clamp(0.0, 1.0);
                distance_m + (laser.distance_m - nearby_m[axis]) * (share - 1.0)
            })
        }
    };
    let height_m = far_forward_m * sin_vertical + vertical_m * cos_vertical;
    [forward_m(along_m(far_forward_m)), -right_m(along_m(far_right_m)), height_m]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::velodyne_capture::laser_table::lasers_of;

    /// A packet whose columns begin at 10° and are `step` apart, with `distance` everywhere.
    fn packet(flags: [u16; 2], last: [u8; 2], step: u16, distance: u16) -> [u8; N_PACKET_BYTES] {
        let mut bytes = [0; N_PACKET_BYTES];
        for block in 0..N_BLOCKS {
            let at = block * N_BLOCK_BYTES;
            bytes[at..at + 2].copy_from_slice(&flags[block % 2].to_le_bytes());
            bytes[at + 2..at + 4].copy_from_slice(&(1000 + step * block as u16).to_le_bytes());
            for index in 0..N_MEASUREMENTS {
                let at = at + 4 + 3 * index;
                bytes[at..at + 2].copy_from_slice(&distance.to_le_bytes());
                bytes[at + 2] = 51;
            }
        }
        bytes[N_PACKET_BYTES - 2..].copy_from_slice(&last);
        bytes
    }

    fn points(bytes: &[u8; N_PACKET_BYTES]) -> detector::PointCloud {
        let packet = DataPacket::parse(bytes).unwrap();
        let mut points = PositionedPoints::default();
        let mut firings = Vec::new();
        packet.append_points(0..N_BLOCKS, &lasers_of(packet.model()), &mut points, &mut firings).unwrap();
        assert_eq!(firings.len(), points.n_in_file());
        points.into_parts().0
    }

    /// The last firing of a packet.
    fn last_firing(bytes: &[u8; N_PACKET_BYTES]) -> Firing {
        let packet = DataPacket::parse(bytes).unwrap();
        let (mut points, mut firings) = (PositionedPoints::default(), Vec::new());
        packet.append_points(0..N_BLOCKS, &lasers_of(packet.model()), &mut points, &mut firings).unwrap();
        *firings.last().unwrap()
    }

    #[test]
    fn lasers_fire_one_after_the_other() {
        let check = |bytes: [u8; N_PACKET_BYTES], laser_idx: usize, micros: f32| {
            let last = last_firing(&bytes);
            assert_eq!(last.laser_idx, laser_idx);
            assert!((last.micros - micros).abs() < 1e-3, "{last:?}");
        };
        check(packet([FIRST_BANK; 2], [0x37, 0x22], 40, 5000), 15, 11.0 * 110.592 + 55.296 + 15.0 * 2.304);
        check(packet([FIRST_BANK; 2], [0x37, 0x21], 10, 5000), 31, 11.0 * 46.08 + 31.0 * 1.152);
        let mut stamped = packet([FIRST_BANK; 2], [0x37, 0x21], 10, 5000);
        stamped[N_PACKET_BYTES - 6..N_PACKET_BYTES - 2].copy_from_slice(&1_000_000_u32.to_le_bytes());
        assert_eq!(DataPacket::parse(&stamped).unwrap().micros_of_hour(), 1_000_000);
    }

    #[test]
    fn a_point_lies_where_its_laser_and_the_head_point() {
        let cloud = points(&packet([FIRST_BANK; 2], [0x37, 0x22], 40, 5000));
        assert_eq!(cloud.len(), 12 * 32);
        let [x, y, z] = cloud.position_m(0);
        // 10 m at 10° to the right, 15° down.
        let expected = [9.659_26 * 0.984_808, -9.659_26 * 0.173_648, -2.588_19 + 0.0108];
        assert!((x - expected[0]).abs() < 4e-3 && (y - expected[1]).abs() < 4e-3, "{x} {y}");
        assert!((z - expected[2]).abs() < 4e-3, "{z}");
        assert_eq!(cloud.intensity()[0], 0.2);
        // The second firing is half a step later.
        let azimuth_of = |idx: usize| (-cloud.y_m()[idx]).atan2(cloud.x_m()[idx]).to_degrees();
        assert!((azimuth_of(16) - 10.2).abs() < 1e-3, "{}", azimuth_of(16));
        assert!((azimuth_of(11 * 32) - 14.4).abs() < 1e-3);
    }

    #[test]
    fn of_two_returns_the_last_is_taken_and_of_none_nothing() {
        assert_eq!(points(&packet([FIRST_BANK; 2], [0x39, 0x21], 10, 5000)).len(), 6 * 32);
        assert_eq!(points(&packet([FIRST_BANK; 2], [0x37, 0x21], 10, 0)).len(), 0);
    }

    #[test]
    fn sensors_are_recognised_by_their_packets() {
        let model = |bytes: [u8; N_PACKET_BYTES]| DataPacket::parse(&bytes).map(|it| it.model());
        assert_eq!(model(packet([FIRST_BANK; 2], [0x37, 0x21], 10, 1)), Ok(VelodyneModel::Hdl32e));
        assert_eq!(model(packet([FIRST_BANK, SECOND_BANK], [0x37, 0x99], 10, 1)), Ok(VelodyneModel::Hdl64e));
        assert!(model(packet([FIRST_BANK; 2], [0x37, 0x28], 10, 1)).expect_err("another").contains("0x28"));
        assert!(model(packet([0x1234; 2], [0x37, 0x21], 10, 1)).expect_err("no packet").contains("0x1234"));
        assert!(
            model(packet([FIRST_BANK; 2], [0x37, 0x21], 4000, 1)).expect_err("a turn").contains("azimuth")
        );
    }

    #[test]
    fn corrections_add_up_at_the_distances_that_were_measured() {
        let laser = Laser { distance_m: 1.0, distance_nearby_m: Some([1.2, 1.5]), ..Laser::default() };
        let [x, y, _] = position_m(&laser, 0.0, FAR_M - 1.0);
        assert!((x - FAR_M).abs() < 1e-4 && y.abs() < 1e-4, "{x} {y}");
        let [x, _, _] = position_m(&laser, 0.0, NEAR_M[1] - 1.0);
        assert!((x - (NEAR_M[1] + 0.5)).abs() < 1e-4, "{x}");
        let [x, _, _] = position_m(&laser, 0.0, 99.0);
        assert!((x - 100.0).abs() < 1e-4, "{x}");
    }
}
