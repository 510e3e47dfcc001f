//! Packets of Velodyne's sensors, drawn, and captures of them.

use std::fmt::Write as _;

/// How far a laser of [`packets`] sees, in steps of 2 mm.
pub fn steps_of(laser: usize, azimuth: usize) -> u16 {
    if (laser + azimuth / 100).is_multiple_of(11) { 0 } else { (2000 + 37 * laser + azimuth % 5000) as u16 }
}

/// Packets of so many columns in a row from this azimuth on, in hundredths of a degree: with the bytes at their ends, and so
/// many blocks of a column.
pub fn packets(first: usize, n_columns: usize, step: usize, n_banks: usize, last: [u8; 2]) -> Vec<Vec<u8>> {
    let columns: Vec<usize> = (0..n_columns).map(|it| (first + it * step) % 36_000).collect();
    let packet = |columns: &[usize]| {
        let mut bytes = Vec::with_capacity(1206);
        for &azimuth in columns {
            for bank in 0..n_banks {
                bytes.extend([0xeeff_u16, 0xddff][bank].to_le_bytes());
                bytes.extend((azimuth as u16).to_le_bytes());
                for index in 0..32 {
                    bytes.extend(steps_of(index + 32 * bank, azimuth).to_le_bytes());
                    bytes.push((azimuth % 256) as u8);
                }
            }
        }
        bytes.extend([0, 0, 0, 0]);
        bytes.extend(last);
        bytes
    };
    columns.chunks_exact(12 / n_banks).map(packet).collect()
}

/// A head that turns, and what is seen of it.
#[derive(Debug, Clone, Copy)]
pub struct Head {
    /// The azimuths between which it sees, in hundredths of a degree, through 0 where the first is greater. All round if they
    /// are the same.
    pub field: [u32; 2],
    /// Where it begins, in hundredths of a degree.
    pub first: u32,
    /// How far it turns, in hundredths of a degree.
    pub turned: u32,
    pub turns_per_s: u32,
    pub is_clockwise: bool,
    /// How many blocks of a packet show the same moment.
    pub n_blocks_of_column: usize,
    /// The last bytes of packets.
    pub last: [u8; 2],
}

/// A packet as it was captured.
#[derive(Debug, Clone)]
pub struct Captured {
    pub time_ns: u64,
    pub bytes: Vec<u8>,
    /// For each block, how often the head has passed the middle of what it does not see, or 0 where it sees all round.
    pub turns: [u32; 12],
}

impl Head {
    /// How far `azimuth` is in the field of view, as a share of a whole turn, if it is.
    fn seen(&self, azimuth: u32) -> bool {
        let [from, to] = self.field;
        from == to || (azimuth + 36_000 - from) % 36_000 <= (to + 36_000 - from) % 36_000
    }

    /// Where turns begin.
    fn cut(&self) -> u32 {
        let [from, to] = self.field;
        if from == to { 0 } else { (to + (from + 36_000 - to) % 36_000 / 2) % 36_000 }
    }

    /// The packets, of columns that are 111 microseconds apart.
    pub fn packets(&self) -> Vec<Captured> {
        const COLUMN_NS: u64 = 110_592;
        let turned_at =
            |column: u64| column * COLUMN_NS * u64::from(self.turns_per_s) * 36_000 / 1_000_000_000;
        let since_cut = if self.is_clockwise {
            self.first + 36_000 - self.cut()
        } else {
            self.cut() + 36_000 - self.first
        } % 36_000;
        let seen = (0..).map_while(|column| {
            let turned = turned_at(column) as u32;
            let azimuth = if self.is_clockwise {
                self.first + turned
            } else {
                self.first + 36_000 * (1 + turned / 36_000) - turned
            } % 36_000;
            let column = (column, azimuth, (since_cut + turned) / 36_000);
            (turned < self.turned).then_some(column)
        });
        let seen: Vec<(u64, u32, u32)> = seen.filter(|it| self.seen(it.1)).collect();
        seen.chunks_exact(12 / self.n_blocks_of_column)
            .map(|columns| self.packet(columns, COLUMN_NS))
            .collect()
    }

    fn packet(&self, columns: &[(u64, u32, u32)], column_ns: u64) -> Captured {
        let mut bytes = Vec::with_capacity(1206);
        let mut turns = Vec::with_capacity(12);
        let has_banks = self.last == [0, 0];
        for &(_, azimuth, turn) in columns {
            for block in 0..self.n_blocks_of_column {
                let bank = if has_banks { block % 2 } else { 0 };
                bytes.extend([0xeeff_u16, 0xddff][bank].to_le_bytes());
                bytes.extend((azimuth as u16).to_le_bytes());
                for index in 0..32 {
                    bytes.extend(steps_of(index + 32 * bank, azimuth as usize).to_le_bytes());
                    bytes.push((azimuth % 256) as u8);
                }
                turns.push(turn);
            }
        }
        let [first_ns, last_ns] = [columns[0].0, columns[columns.len() - 1].0].map(|it| it * column_ns);
        bytes.extend(((first_ns / 1000) as u32).to_le_bytes());
        bytes.extend(self.last);
        let time_ns = 1_600_000_000_000_000_000 + last_ns;
        Captured { time_ns, bytes, turns: turns.try_into().unwrap() }
    }
}

/// The packet on the wire: to port 2368 of everybody, from this sensor of the network.
fn datagram(payload: &[u8], sensor: u8) -> Vec<u8> {
    let mut bytes = vec![0xff; 12];
    bytes.extend([8, 0, 0x45, 0]);
    bytes.extend((28 + payload.len() as u16).to_be_bytes());
    bytes.extend([0, 0, 0x40, 0, 64, 17, 0, 0, 192, 168, 1, sensor, 255, 255, 255, 255]);
    bytes.extend(2368_u16.to_be_bytes());
    bytes.extend(2368_u16.to_be_bytes());
    bytes.extend((8 + payload.len() as u16).to_be_bytes());
    bytes.extend([0, 0]);
    bytes.extend(payload);
    bytes
}

/// A capture of packets that are 1.327 ms apart.
pub fn pcap(packets: &[Vec<u8>]) -> Vec<u8> {
    let at = |(number, packet): (u64, &Vec<u8>)| {
        (1_600_000_000_000_000_000 + 1_327_000 * number, packet.clone(), 201)
    };
    pcap_at(&(0..).zip(packets).map(at).collect::<Vec<_>>())
}

/// A capture of packets: when, which, and from which sensor.
pub fn pcap_at(packets: &[(u64, Vec<u8>, u8)]) -> Vec<u8> {
    let mut bytes = vec![0xd4, 0xc3, 0xb2, 0xa1, 2, 0, 4, 0];
    bytes.extend([0; 8]);
    bytes.extend(65_535_u32.to_le_bytes());
    bytes.extend(1_u32.to_le_bytes());
    for (time_ns, packet, sensor) in packets {
        let frame = datagram(packet, *sensor);
        let (seconds, micros) = (time_ns / 1_000_000_000, time_ns / 1000 % 1_000_000);
        for word in [seconds as u32, micros as u32, frame.len() as u32, frame.len() as u32] {
            bytes.extend(word.to_le_bytes());
        }
        bytes.extend(frame);
    }
    bytes
}

/// The same as pcapng, with times in nanoseconds.
pub fn pcapng(packets: &[Vec<u8>]) -> Vec<u8> {
    let block = |kind: u32, body: &[u8]| {
        let length = (12 + body.len()) as u32;
        [&kind.to_le_bytes()[..], &length.to_le_bytes(), body, &length.to_le_bytes()].concat()
    };
    let mut bytes =
        block(0x0a0d_0d0a, &[0x4d, 0x3c, 0x2b, 0x1a, 1, 0, 0, 0, 255, 255, 255, 255, 255, 255, 255, 255]);
    bytes.extend(block(1, &[1, 0, 0, 0, 0, 0, 0, 0, 9, 0, 1, 0, 9, 0, 0, 0, 0, 0, 0, 0]));
    for (number, packet) in packets.iter().enumerate() {
        let frame = datagram(packet, 201);
        let time_ns = 1_600_000_000_000_000_000_u64 + 1_327_000 * number as u64;
        let mut body = vec![0; 4];
        for word in [(time_ns >> 32) as u32, time_ns as u32, frame.len() as u32, frame.len() as u32] {
            body.extend(word.to_le_bytes());
        }
        body.extend(&frame);
        body.resize(body.len().next_multiple_of(4), 0);
        bytes.extend(block(6, &body));
    }
    bytes
}

/// A calibration of 64 lasers, drawn, in YAML.
pub fn calibration_of_64() -> String {
    let mut text = "distance_resolution: 0.002\nlasers:\n".to_owned();
    for id in 0..64 {
        writeln!(
            text,
            "- {{laser_id: {id}, vert_correction: {}, rot_correction: {}, dist_correction: {}, dist_correction_x: {}, \
             dist_correction_y: {}, vert_offset_correction: {}, horiz_offset_correction: {}, focal_distance: 10.0, \
             focal_slope: 1.0, min_intensity: 0, max_intensity: 255}}",
            0.035 - 0.0073 * f64::from(id),
            0.02 * f64::from(id % 5) - 0.04,
            1.0 + 0.01 * f64::from(id % 7),
            1.1 + 0.01 * f64::from(id % 3),
            1.05 + 0.01 * f64::from(id % 4),
            0.1 + 0.001 * f64::from(id),
            if id % 2 == 0 { 0.026 } else { -0.026 },
        )
        .unwrap();
    }
    text + "num_lasers: 64\n"
}
