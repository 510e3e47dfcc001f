//! Labels that lie where the points are, and labels that were damaged: which damage is heard, and how small it may be.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::f32::consts::{FRAC_PI_2, PI};

use detector::OrientedBox;
use scans::annotation::LabeledScan;
use scans::data_check::label_correction::Correction;
use scans::data_check::label_look::LabelLook;
use scans::data_check::label_suspicion::{LabelSuspicion, TakenFor};
use scans::dataset::Dataset;
use simulator::catalogue::built_in_catalogue;
use simulator::open::{OpenOptions, open_dataset};
use test_data::test_data;

/// Scans of a data set that are looked at, each with the one that follows it.
struct Looked {
    name: String,
    scans: Vec<LabeledScan>,
    next: Vec<(usize, LabeledScan)>,
}

const N_SCANS: usize = 5;

impl Looked {
    fn of(name: &str, dataset: &dyn Dataset) -> Self {
        let n = dataset.scan_ids().len();
        let indices: Vec<usize> = (0..n.min(N_SCANS)).map(|it| it * n / n.min(N_SCANS)).collect();
        let read = |index: usize| dataset.read_scan(index).unwrap();
        let follows = |index: usize| {
            let [id, next] = [index, index + 1].map(|it| dataset.scan_ids().get(it));
            next.is_some_and(|next| next.sequence == id.unwrap().sequence)
        };
        let has_next = indices.iter().enumerate().filter(|(_, index)| follows(**index));
        Self {
            name: name.to_owned(),
            scans: indices.iter().map(|it| read(*it)).collect(),
            next: has_next.map(|(idx, index)| (idx, read(index + 1))).collect(),
        }
    }

    fn recorded(folder: &str) -> Self {
        let path = test_data(folder);
        let options = OpenOptions::default();
        let dataset = open_dataset(path.to_str().unwrap(), &options, &built_in_catalogue().unwrap()).unwrap();
        Self::of(folder.split('/').nth(1).unwrap(), &*dataset)
    }

    fn street(street: &str, sensor: &str) -> Self {
        let options = OpenOptions {
            seed: Some(9001),
            n_simulated_scans: Some(2 * N_SCANS as u32),
            sensor: Some(sensor.to_owned()),
            ..OpenOptions::default()
        };
        let dataset = open_dataset(street, &options, &built_in_catalogue().unwrap()).unwrap();
        Self::of(&format!("{street}, {sensor}"), &*dataset)
    }

    /// What is suspect if all boxes are `damaged`.
    fn suspicions(&self, damaged: impl Fn(&OrientedBox) -> OrientedBox) -> Vec<LabelSuspicion> {
        let damage = |scan: &LabeledScan| {
            let mut scan = scan.clone();
            for it in scan.annotations.iter_mut().filter_map(|it| it.bounding_box.as_mut()) {
                *it = damaged(it);
            }
            scan
        };
        let scans: Vec<LabeledScan> = self.scans.iter().map(damage).collect();
        let next = || self.next.iter().map(|(idx, it)| (*idx, damage(it))).collect();
        LabelLook::of(&scans, next).suspicions
    }

    /// What is suspect if one box in so many holds no point.
    fn suspicions_with_holes(&self, one_in: usize) -> Vec<LabelSuspicion> {
        let mut scans = self.scans.clone();
        let boxes =
            scans.iter_mut().flat_map(|it| &mut it.annotations).filter(|it| it.bounding_box.is_some());
        boxes.step_by(one_in).for_each(|it| it.point_indices.clear());
        LabelLook::of(&scans, Vec::new).suspicions
    }

    /// What is suspect if each scan has the labels of the one before it.
    fn suspicions_if_late(&self) -> Vec<LabelSuspicion> {
        // The points of the next scan with the labels of this one, and those of this one for the next, which are the right
        // ones.
        let late = |(idx, next): &(usize, LabeledScan)| LabeledScan {
            annotations: self.scans[*idx].annotations.clone(),
            ..next.clone()
        };
        let scans: Vec<LabeledScan> = self.next.iter().map(late).collect();
        LabelLook::of(&scans, || self.next.iter().map(|it| it.1.clone()).enumerate().collect()).suspicions
    }
}

fn raised(by: impl Fn(f32) -> f32) -> impl Fn(&OrientedBox) -> OrientedBox {
    move |it| {
        let mut raised = *it;
        raised.center_m[2] += by(it.length_width_height_m[2]);
        raised
    }
}

fn corrections(suspicions: &[LabelSuspicion]) -> Vec<Correction> {
    let position = |it: &LabelSuspicion| match it {
        LabelSuspicion::Position { correction, .. } => Some(*correction),
        _ => None,
    };
    suspicions.iter().filter_map(position).collect()
}

/// Damages the labels of `looked` by `damage`, and expects a correction like this one.
#[track_caller]
fn check(looked: &Looked, damage: Correction, expected: impl Fn(Correction) -> bool) {
    let suspicions = looked.suspicions(|it| damage.of(it));
    let found = corrections(&suspicions);
    let is_expected = found.iter().any(|it| expected(*it));
    assert!(is_expected, "{}: {damage:?} gives {suspicions:?}", looked.name);
}

fn near(found: f32, expected: f32, tolerance: f32) -> bool {
    (found - expected).abs() <= tolerance
}

/// Boxes beside their vehicles are heard on `looked`, and called by what is wrong.
#[track_caller]
fn check_positions(looked: &Looked) {
    check(looked, Correction::SwapSides, |it| it == Correction::SwapSides);
    check(
        looked,
        Correction::Shift([0.6, -0.5]),
        |it| matches!(it, Correction::Shift([x, y]) if near(x, -0.6, 0.3) && near(y, 0.5, 0.3)),
    );
    check(
        looked,
        Correction::OwnShift([-1.3, 0.0]),
        |it| matches!(it, Correction::OwnShift([along, _]) if near(along, 1.3, 0.3)),
    );
    check(
        looked,
        Correction::Turn(5_f32.to_radians()),
        |it| matches!(it, Correction::Turn(by) if near(by.to_degrees(), -5.0, 1.0)),
    );
}

/// Each kind of damage is heard on `looked`, and called by its name.
#[track_caller]
fn check_all(looked: &Looked) {
    check_positions(looked);
    check(
        looked,
        Correction::Yaw(20_f32.to_radians()),
        |it| matches!(it, Correction::Yaw(by) if near(by.to_degrees(), -20.0, 5.0)),
    );
    check(looked, Correction::Scale(1.4), |it| matches!(it, Correction::Scale(by) if near(by, 0.7, 0.1)));
    check(looked, Correction::Mirror, |it| it == Correction::Mirror);
    check(
        looked,
        Correction::Turn(FRAC_PI_2),
        |it| matches!(it, Correction::Turn(by) if near(by, -FRAC_PI_2, 0.01)),
    );
    check(looked, Correction::ExchangeAxes, |it| it == Correction::ExchangeAxes);
    let has_height = |expected: TakenFor, suspicions: Vec<LabelSuspicion>| {
        let is_it = |it: &LabelSuspicion| matches!(it, LabelSuspicion::Height { taken_for, .. } if *taken_for == expected);
        assert!(suspicions.iter().any(is_it), "{}: {suspicions:?}", looked.name);
    };
    has_height(TakenFor::BottomForCentre, looked.suspicions(raised(|height_m| -0.5 * height_m)));
    has_height(TakenFor::CentreForBottom, looked.suspicions(raised(|height_m| 0.5 * height_m)));
    has_height(TakenFor::Unknown, looked.suspicions(raised(|_| 1.73)));
    let degrees = looked.suspicions(|it| OrientedBox { yaw_rad: it.yaw_rad.to_degrees() + 20.0, ..*it });
    assert!(degrees.iter().any(|it| matches!(it, LabelSuspicion::Degrees { .. })), "degrees {degrees:?}");
    let holes = looked.suspicions_with_holes(3);
    assert!(holes.iter().any(|it| matches!(it, LabelSuspicion::Holes { .. })), "{}: {holes:?}", looked.name);
    let sideways = looked.suspicions(|it| Correction::Yaw(FRAC_PI_2).of(&Correction::SwapSides.of(it)));
    assert!(sideways.iter().any(|it| matches!(it, LabelSuspicion::Sideways { .. })), "sideways {sideways:?}");
}

#[test]
fn labels_of_streets_are_silent_and_their_damage_is_named() {
    for street in ["street-main-road", "street-narrow", "street-intersection"] {
        let looked = Looked::street(street, "hdl-64e-s2");
        assert_eq!(looked.suspicions(|it| *it), [], "{}", looked.name);
        check_all(&looked);
    }
}

#[test]
#[ignore = "needs data/kitti_tracking, data/kitti_object, data/semantic_kitti and data/argoverse2 in SCANBENCH_TEST_DATA"]
fn real_labels_are_silent_and_their_damage_is_named() {
    for looked in recorded() {
        assert_eq!(looked.suspicions(|it| *it), [], "{}", looked.name);
        // One scan with 16 vehicles does not show every kind of damage.
        if looked.scans.len() > 1 { check_all(&looked) } else { check_positions(&looked) }
    }
    let kitti = Looked::recorded("data/kitti_tracking");
    let late = Correction::OtherScan { is_next: true };
    assert_eq!(corrections(&kitti.suspicions_if_late()), [late]);
    assert_eq!(Looked::recorded("data/semantic_kitti").suspicions(|it| *it), []);
}

#[test]
#[ignore = "simulates streets for minutes"]
fn labels_of_all_streets_are_silent_with_all_sensors() {
    for sensor in ["hdl-64e-s2", "hdl-32e", "vlp-16", "os1-128", "os0-128", "pandar64", "xt32"] {
        for street in ["street-main-road", "street-narrow", "street-intersection"] {
            let looked = Looked::street(street, sensor);
            assert_eq!(looked.suspicions(|it| *it), [], "{}", looked.name);
        }
    }
}

fn recorded() -> Vec<Looked> {
    ["data/kitti_tracking", "data/kitti_object", "data/argoverse2/sensor/val"].map(Looked::recorded).into()
}

#[test]
#[ignore = "prints the table of docs/your-data.md; needs data/kitti_tracking, data/kitti_object and data/argoverse2 in SCANBENCH_TEST_DATA"]
fn how_small_a_damage_is_heard() {
    type Damage = (&'static str, &'static str, fn(f32) -> Correction, [f32; 8]);
    let damages: [Damage; 8] = [
        ("shift forward", "m", |it| Correction::Shift([it, 0.0]), [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0]),
        ("shift back", "m", |it| Correction::Shift([-it, 0.0]), [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0]),
        ("shift left", "m", |it| Correction::Shift([0.0, it]), [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0]),
        (
            "along the own heading",
            "m",
            |it| Correction::OwnShift([it, 0.0]),
            [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0],
        ),
        (
            "turn about the sensor",
            "°",
            |it| Correction::Turn(it.to_radians()),
            [0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0],
        ),
        ("yaw", "°", |it| Correction::Yaw(it.to_radians()), [3.0, 5.0, 7.0, 8.0, 10.0, 12.0, 15.0, 20.0]),
        ("boxes larger", "times", Correction::Scale, [1.05, 1.1, 1.15, 1.2, 1.25, 1.3, 1.4, 1.5]),
        ("boxes smaller", "times", Correction::Scale, [0.95, 0.9, 0.85, 0.8, 0.75, 0.7, 0.6, 0.5]),
    ];
    let mut all = recorded();
    for sensor in ["hdl-64e-s2", "vlp-16"] {
        all.extend(["street-main-road", "street-narrow"].map(|it| Looked::street(it, sensor)));
    }
    let heights = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0];
    for looked in &all {
        let started = std::time::Instant::now();
        let silent = looked.suspicions(|it| *it);
        let took_ms = started.elapsed().as_millis();
        let first = |sizes: &[f32], suspicions: &dyn Fn(f32) -> Vec<LabelSuspicion>| {
            let n_silent = sizes.iter().rev().take_while(|it| !suspicions(**it).is_empty()).count();
            sizes.get(sizes.len() - n_silent).map_or_else(|| "–".to_owned(), ToString::to_string)
        };
        let mut cells: Vec<String> = damages
            .iter()
            .map(|(name, unit, damage, sizes)| {
                let of_size = |size: f32| looked.suspicions(|it| damage(size).of(it));
                format!("{name} {} {unit}", first(sizes, &of_size))
            })
            .collect();
        cells.push(format!("height {} m", first(&heights, &|size| looked.suspicions(raised(move |_| size)))));
        let is_heard = |one_in: &usize| !looked.suspicions_with_holes(*one_in).is_empty();
        let holes = (2..=10).rev().find(is_heard).map_or_else(|| "–".to_owned(), |it| it.to_string());
        cells.push(format!("empty 1 in {holes}"));
        let n = corrections(&looked.suspicions(|it| Correction::Turn(PI).of(it))).len();
        let late = corrections(&looked.suspicions_if_late());
        eprintln!(
            "| {} | {took_ms} ms | undamaged {silent:?} | {} | turned back {n} | late {late:?} |",
            looked.name,
            cells.join(" | ")
        );
    }
}

#[test]
fn labels_to_one_side_of_scans_all_round_are_named() {
    let mut looked = Looked::street("street-main-road", "hdl-64e-s2");
    let is_sector = |it: &LabelSuspicion| matches!(it, LabelSuspicion::Sector { .. });
    assert!(!LabelLook::of(&looked.scans, Vec::new).suspicions.iter().any(is_sector));
    for scan in &mut looked.scans {
        // Behind the sensor, where azimuths go from 180 to -180 degrees.
        scan.annotations.retain(|it| {
            let [x_m, y_m, _] = it.bounding_box.map_or([1.0, 0.0, 0.0], |it| it.center_m);
            y_m.atan2(-x_m).abs() < 50_f32.to_radians()
        });
    }
    let suspicions = LabelLook::of(&looked.scans, Vec::new).suspicions;
    let found = suspicions.iter().find(|it| is_sector(it)).expect("they lie within 100 degrees");
    let LabelSuspicion::Sector { width_deg, share_elsewhere, n_boxes } = *found else { unreachable!() };
    assert!((50.0..100.0).contains(&width_deg) && n_boxes >= 15, "{found:?}");
    assert!((0.6..0.9).contains(&share_elsewhere), "{found:?}");
}
