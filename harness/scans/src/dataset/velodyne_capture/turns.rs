//! Cuts the packets of a spinning head into turns, by their azimuths.
//!
//! A turn begins where nothing is seen: in the middle of the blind arc of a sensor with a limited field of view, or else at
//! azimuth 0. It ends when the head passes this azimuth, also by a jump over it.

use super::data_packet::{FULL_TURN, MAX_STEP, N_BLOCKS, Rotation};

/// After a longer time without a packet, in nanoseconds, the number of turns of the head is unknown.
const MAX_PAUSE_NS: u64 = 40_000_000;

/// A turn that begins and ends this near to the ends of the field of view is whole, in hundredths of a degree; in a narrow
/// field, within the given part of it.
const WHOLE_WITHIN: u16 = 500;
const WHOLE_WITHIN_PART: u16 = 20;

/// The head goes back no farther than this, by the noise of its encoder, in hundredths of a degree.
const MAX_BACK: u16 = 100;

/// Blind arcs are at least this wide, in hundredths of a degree.
const MIN_BLIND: u16 = 500;

/// If only whole packets are missing, they may be lost: an arc is blind only if this much is missing in all turns together,
/// in hundredths of a degree.
const MIN_BLIND_BETWEEN_PACKETS: usize = 9_000;

/// The azimuths of a packet, and the time of its capture.
#[derive(Debug, Clone, Copy)]
pub struct PacketAzimuths {
    /// The azimuths of its blocks, in hundredths of a degree.
    pub azimuths: [u16; N_BLOCKS],
    /// The time of its capture, in nanoseconds.
    pub time_ns: u64,
}

/// The packets of a turn; the first and the last may belong to it only in part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Turn {
    /// The packet with the first block of the turn.
    pub first_packet: usize,
    /// The first block, as an index in this packet.
    pub first_block: usize,
    /// The packet with the last block of the turn.
    pub last_packet: usize,
    /// The index behind the last block in that packet.
    pub end_block: usize,
    /// Whether it spans the whole field of view.
    is_whole: bool,
}

/// The turns of `packets`, and the direction in which the head turns.
///
/// Incomplete turns at the beginning and the end are left out, unless there are no others.
pub fn turns_of(packets: &[PacketAzimuths]) -> (Vec<Turn>, Rotation) {
    let field = Field::of(packets);
    let mut turns = cut(packets, field);
    if turns.iter().any(|it| it.is_whole) {
        if turns.first().is_some_and(|it| !it.is_whole) {
            turns.remove(0);
        }
        if turns.last().is_some_and(|it| !it.is_whole) {
            turns.pop();
        }
    }
    (turns, field.rotation)
}

/// The field of view, as seen in all turns together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Field {
    rotation: Rotation,
    /// The azimuth at which turns begin.
    cut: u16,
    /// The width of the blind arc around it; 0 if there is none.
    blind: u16,
}

/// The blocks of `packets`, each with the azimuth of the one before: packet, block and both azimuths.
fn steps(packets: &[PacketAzimuths]) -> impl Iterator<Item = (usize, usize, [u16; 2])> {
    let azimuths = packets.iter().enumerate().flat_map(|(packet_idx, it)| {
        it.azimuths.iter().enumerate().map(move |(block, azimuth)| (packet_idx, block, *azimuth))
    });
    let mut last = None;
    azimuths.map(move |(packet_idx, block, azimuth)| {
        let before = last.replace(azimuth).unwrap_or(azimuth);
        (packet_idx, block, [before, azimuth])
    })
}

impl Field {
    fn of(packets: &[PacketAzimuths]) -> Self {
        let rotation = rotation_of(packets);
        let full = Self { rotation, cut: 0, blind: 0 };
        let (first, width) = widest_unseen(packets);
        // Counted from there on, as turns are.
        let middle = (u32::from(first) + u32::from(width) / 2) % u32::from(FULL_TURN);
        let limited = Self { cut: middle as u16, blind: width, ..full };
        let (mut n_jumps, mut n_within_packets) = (0_usize, 0_usize);
        for (_, block, [before, azimuth]) in steps(packets) {
            let forward = rotation.from(before, azimuth);
            if forward <= FULL_TURN - MAX_BACK && rotation.from(before, limited.cut) < forward {
                n_jumps += 1;
                n_within_packets += usize::from(block > 0);
            }
        }
        let is_blind = n_within_packets > 0 || n_jumps * usize::from(width) >= MIN_BLIND_BETWEEN_PACKETS;
        if width >= MIN_BLIND && is_blind { limited } else { full }
    }

    /// How far the head has turned since the cut, in hundredths of a degree.
    fn progress(self, azimuth: u16) -> u16 {
        self.rotation.from(self.cut, azimuth)
    }

    /// Whether blocks from azimuth `first` to azimuth `last` span the field of view.
    fn is_whole(self, first: u16, last: u16) -> bool {
        let within = WHOLE_WITHIN.min((FULL_TURN - self.blind) / WHOLE_WITHIN_PART);
        let reach = self.blind / 2 + within;
        self.progress(first) <= reach && self.progress(last) >= FULL_TURN - reach
    }
}

/// The direction of most of the small steps.
fn rotation_of(packets: &[PacketAzimuths]) -> Rotation {
    let (mut n_clockwise, mut n_others) = (0_usize, 0_usize);
    for (.., [before, azimuth]) in steps(packets) {
        let is_step = |rotation: Rotation| (1..=MAX_STEP).contains(&rotation.from(before, azimuth));
        n_clockwise += usize::from(is_step(Rotation::Clockwise));
        n_others += usize::from(is_step(Rotation::CounterClockwise));
    }
    if n_clockwise >= n_others { Rotation::Clockwise } else { Rotation::CounterClockwise }
}

/// The first azimuth and the width of the widest arc without a block, in hundredths of a degree.
fn widest_unseen(packets: &[PacketAzimuths]) -> (u16, u16) {
    let mut is_seen = vec![false; usize::from(FULL_TURN)];
    for azimuth in packets.iter().flat_map(|it| it.azimuths) {
        if let Some(seen) = is_seen.get_mut(usize::from(azimuth)) {
            *seen = true;
        }
    }
    let seen: Vec<u16> = (0..FULL_TURN).filter(|it| is_seen[usize::from(*it)]).collect();
    let next = seen.iter().skip(1).chain(seen.first());
    let arcs = seen.iter().zip(next).map(|(last, next)| {
        let between = Rotation::Clockwise.from(*last, *next);
        let width = if between == 0 { FULL_TURN - 1 } else { between - 1 };
        ((*last + 1) % FULL_TURN, width)
    });
    arcs.max_by_key(|it| it.1).unwrap_or_default()
}

/// Cuts where the head passes the cut for the first time, and after each pause in which it may have.
fn cut(packets: &[PacketAzimuths], field: Field) -> Vec<Turn> {
    let pauses = Pauses::of(packets, field);
    let mut turns: Vec<Turn> = Vec::new();
    // Hundredths of a degree from the cut before the first block, and whole turns by them.
    let mut turned = packets.first().map_or(0, |it| i64::from(field.progress(it.azimuths[0])));
    let mut n_turned = 0;
    let mut first_azimuth = 0;
    for (packet_idx, block, [before, azimuth]) in steps(packets) {
        turned += field.step(before, azimuth);
        let n_now = turned.div_euclid(i64::from(FULL_TURN));
        let has_passed = n_now > n_turned;
        n_turned = n_turned.max(n_now);
        let is_after_pause = || block == 0 && pauses.may_hide_a_turn(packets, field, packet_idx);
        if turns.is_empty() || has_passed || is_after_pause() {
            turns.push(Turn {
                first_packet: packet_idx,
                first_block: block,
                last_packet: packet_idx,
                end_block: block,
                is_whole: false,
            });
            first_azimuth = azimuth;
        }
        if let Some(turn) = turns.last_mut() {
            (turn.last_packet, turn.end_block) = (packet_idx, block + 1);
            turn.is_whole = field.is_whole(first_azimuth, azimuth);
        }
    }
    turns
}

impl Field {
    /// How far the head turns from one block to the next, in hundredths of a degree: forward, or back by noise.
    fn step(self, before: u16, azimuth: u16) -> i64 {
        let forward = self.rotation.from(before, azimuth);
        let back = if forward > FULL_TURN - MAX_BACK { FULL_TURN } else { 0 };
        i64::from(forward) - i64::from(back)
    }

    /// Hundredths of a degree from the last block of one packet to that of the next, and whether the head passes the cut.
    fn motion(self, [before, packet]: [&PacketAzimuths; 2]) -> (i64, bool) {
        let from = before.azimuths[N_BLOCKS - 1];
        let (mut motion, mut last) = (0, from);
        for azimuth in packet.azimuths {
            motion += self.step(last, azimuth);
            last = azimuth;
        }
        (motion, i64::from(self.progress(from)) + motion >= i64::from(FULL_TURN))
    }
}

/// The time of a turn. Packets of a sensor that sees all round follow one another, and it is not needed. Other sensors are
/// silent for most of a turn; then their packets show how long it takes.
#[derive(Debug, Clone, Copy)]
struct Pauses {
    period_ns: Option<u64>,
}

impl Pauses {
    fn of(packets: &[PacketAzimuths], field: Field) -> Self {
        if field.blind == 0 {
            return Self { period_ns: None };
        }
        let period_ns = |pair: &[PacketAzimuths]| {
            let (motion, has_passed) = field.motion([&pair[0], &pair[1]]);
            let pause_ns = u128::from(pair[1].time_ns.saturating_sub(pair[0].time_ns));
            let motion = u128::try_from(motion).ok().filter(|it| has_passed && *it > 0)?;
            u64::try_from(pause_ns * u128::from(FULL_TURN) / motion).ok()
        };
        let mut periods_ns: Vec<u64> = packets.windows(2).filter_map(period_ns).collect();
        periods_ns.sort_unstable();
        Self { period_ns: periods_ns.get(periods_ns.len() / 2).copied() }
    }

    /// Whether the head may have turned once more before packet `packet_idx` than azimuths show.
    fn may_hide_a_turn(self, packets: &[PacketAzimuths], field: Field, packet_idx: usize) -> bool {
        let Some([before, packet]) = packet_idx.checked_sub(1).and_then(|it| packets.get(it..=packet_idx))
        else {
            return false;
        };
        let pause_ns = packet.time_ns.saturating_sub(before.time_ns);
        let Some(period_ns) = self.period_ns else { return pause_ns > MAX_PAUSE_NS };
        let (motion, _) = field.motion([before, packet]);
        let needed_ns = u128::from(period_ns) * u128::try_from(motion).unwrap_or(0) / u128::from(FULL_TURN);
        let needed_ns = u64::try_from(needed_ns).unwrap_or(u64::MAX);
        pause_ns.saturating_sub(needed_ns) >= (period_ns / 2).max(MAX_PAUSE_NS / 2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Packets of blocks at these azimuths, 1.3 ms apart.
    fn packets(azimuths: impl IntoIterator<Item = u16>) -> Vec<PacketAzimuths> {
        let azimuths: Vec<u16> = azimuths.into_iter().collect();
        let (packets, _) = azimuths.as_chunks::<N_BLOCKS>();
        (0..)
            .zip(packets)
            .map(|(it, azimuths)| PacketAzimuths { azimuths: *azimuths, time_ns: it * 1_300_000 })
            .collect()
    }

    /// The first azimuth of each turn.
    fn begins(packets: &[PacketAzimuths]) -> Vec<u16> {
        let (turns, _) = turns_of(packets);
        turns.iter().map(|it| packets[it.first_packet].azimuths[it.first_block]).collect()
    }

    #[test]
    fn a_head_that_trembles_where_turns_begin_ends_one_turn() {
        let turn = (0..900).map(|it| it * 40);
        let mut azimuths: Vec<u16> =
            turn.clone().chain([35_990, 5, 35_995, 10]).chain(turn.clone().skip(1)).collect();
        azimuths.extend(turn);
        assert_eq!(begins(&packets(azimuths)), [0, 5, 0]);
    }

    #[test]
    fn an_arc_that_is_lost_once_is_not_blind_and_one_that_is_always_missing_is() {
        let from_90 = |n: u32| (0..n).map(|it| ((9000 + 40 * it) % 36_000) as u16);
        // Less than a second turn, without the packets around 70°.
        let mut once = packets(from_90(1500));
        once.drain(68..73);
        assert_eq!(begins(&once), [9000, 0]);
        let never = from_90(2250).filter(|it| !(6000..8000).contains(it));
        assert_eq!(begins(&packets(never)), [8000]);
    }
}
