//! The answer of a detector to a scan, after all checks.

use detector::OrientedBox;
use scans::dataset::class_table::ClassTable;
use scans::foreign::foreign_class::ForeignClass;

use super::message::{MOST_BOXES, NO_TRACK, ResultLine};

/// Longest side of an object, in metres.
const LONGEST_SIDE_M: f32 = 1000.0;
/// Greatest distance of an object from the sensor, in metres along an axis.
const FARTHEST_M: f32 = 10_000.0;
/// Greatest velocity of an object along an axis, in metres per second.
const FASTEST_M_PER_S: f32 = 1000.0;
/// Numbers of a box.
const NUMBERS_OF_BOX: usize = 7;
/// Most products of an answer.
const MOST_PRODUCTS: usize = 32;
/// Longest name of a stage or product.
const LONGEST_NAME: usize = 60;

/// Detections of a detector in a scan, with its stages and products.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Found {
    /// For every point its cluster, 0 for none.
    pub clusters: Option<Vec<u32>>,
    /// Boxes in the frame of the scan; of clusters 1, 2, … if there are clusters.
    pub boxes: Vec<OrientedBox>,
    /// Score of every detection.
    pub scores: Option<Vec<f32>>,
    /// Score of the box of every detection, if it has one.
    pub box_scores: Vec<Option<f32>>,
    /// Velocity of every detection over ground along x and y of the scan, in metres per second, if it has one.
    pub velocities: Vec<Option<[f32; 2]>>,
    /// Track of every detection, if it has one.
    pub tracks: Vec<Option<u32>>,
    /// Boxes that are no detections: unlikely objects, used only where boxes are ranked.
    pub ranked: Vec<RankedBox>,
    /// Class of every detection; `None` where the detector predicts none.
    pub classes: Vec<Option<ForeignClass>>,
    /// Whether the answer has a place for classes, if only for those of no detection.
    pub names_classes: bool,
    /// Stages and their times in milliseconds, as reported.
    pub stages: Vec<(String, f64)>,
    /// Products: their names, and their values, one for each point.
    pub products: Vec<(String, Vec<u8>)>,
}

/// A box that is only ranked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RankedBox {
    /// The box in the frame of the scan.
    pub bounding_box: OrientedBox,
    /// Its score.
    pub score: f32,
    /// Its class; `None` for a vehicle of no class that is known.
    pub class: Option<ForeignClass>,
}

/// Lengths in bytes of the parts of a payload, as far as the line determines them.
struct Parts {
    ids: usize,
    boxes: usize,
    ranked: usize,
    products: usize,
}

impl Found {
    /// Checks the line of a result before the `n_payload_bytes` of its payload are read.
    ///
    /// # Errors
    ///
    /// The problem, as the rest of a sentence.
    pub fn check_line(line: &ResultLine, n_payload_bytes: usize, n_points: usize) -> Result<(), String> {
        for (name, n_boxes) in [("n_boxes", line.n_boxes), ("ranked", line.ranked)] {
            if n_boxes > MOST_BOXES {
                return Err(format!("{name} is {n_boxes}, more than {MOST_BOXES}"));
            }
        }
        if line.products.len() > MOST_PRODUCTS {
            return Err(format!("there are {} products, more than {MOST_PRODUCTS}", line.products.len()));
        }
        for product in &line.products {
            if (product.kind.as_str(), product.value.as_str()) != ("point-labels", "u8") {
                return Err(format!("a product of the kind {:?} and type {:?}", product.kind, product.value));
            }
        }
        let names = line.products.iter().map(|it| &it.name).chain(line.stages.iter().map(|it| &it.name));
        for name in names {
            if name.is_empty() || name.len() > LONGEST_NAME || name.chars().any(char::is_control) {
                return Err(format!("{name:?} is no name of a stage or product"));
            }
        }
        if let Some(stage) = line.stages.iter().find(|it| !(it.ms >= 0.0 && it.ms < 1e9)) {
            return Err(format!("the stage {:?} takes {} ms", stage.name, stage.ms));
        }
        let parts = Parts::of(line, n_points);
        let least = parts.ids + parts.boxes + parts.ranked + parts.products;
        // Without boxes there are as many detections as clusters, which are not more than points.
        let n_bytes_of_detection = bytes_of_detection(line).iter().sum::<usize>();
        let is_open = n_bytes_of_detection > 0 && line.clusters && line.n_boxes == 0;
        let most_of_detections = n_bytes_of_detection * if is_open { n_points } else { line.n_boxes };
        let fits = if is_open {
            (least..=least + most_of_detections).contains(&n_payload_bytes)
        } else {
            n_payload_bytes == least + most_of_detections
        };
        if fits {
            return Ok(());
        }
        let expected = if is_open { least } else { least + most_of_detections };
        let at_least = if is_open { "at least " } else { "" };
        Err(format!(
            "payload_bytes is {n_payload_bytes}, but {n_points} points, {} boxes{}{}{}{}{}{} make {at_least}{expected}",
            line.n_boxes,
            if line.clusters { ", cluster ids" } else { "" },
            if line.scores { ", scores" } else { "" },
            if line.box_scores { ", box scores" } else { "" },
            if line.velocities { ", velocities" } else { "" },
            if line.tracks { ", tracks" } else { "" },
            if line.ranked > 0 { format!(", {} ranked boxes", line.ranked) } else { String::new() },
        ))
    }

    /// Reads the payload of a line that has been [checked](Self::check_line); `table` has the user's names of classes.
    ///
    /// # Errors
    ///
    /// The problem, as the rest of a sentence.
    pub fn read(
        line: &ResultLine,
        payload: &[u8],
        n_points: usize,
        table: &ClassTable,
    ) -> Result<Self, String> {
        let parts = Parts::of(line, n_points);
        let (ids, rest) = payload.split_at(parts.ids);
        let (boxes, rest) = rest.split_at(parts.boxes);
        let clusters = line.clusters.then(|| words(ids).map(u32::from_le_bytes).collect::<Vec<u32>>());
        let boxes = boxes_of("box", boxes)?;
        let n_detections = n_detections(clusters.as_deref(), boxes.len())?;
        let n_bytes_of_detections = bytes_of_detection(line).map(|it| it * n_detections);
        let n_bytes_of_all: usize = n_bytes_of_detections.iter().sum();
        if rest.len() != n_bytes_of_all + parts.ranked + parts.products {
            let expected = parts.ids + parts.boxes + n_bytes_of_all + parts.ranked + parts.products;
            return Err(format!(
                "payload_bytes is {}, but {n_detections} detections make {expected}",
                payload.len()
            ));
        }
        let (scores, rest) = rest.split_at(n_bytes_of_detections[0]);
        let (box_scores, rest) = rest.split_at(n_bytes_of_detections[1]);
        let (velocities, rest) = rest.split_at(n_bytes_of_detections[2]);
        let (tracks, rest) = rest.split_at(n_bytes_of_detections[3]);
        let (ranked, products) = rest.split_at(parts.ranked);
        let (ranked, ranked_scores) = ranked.split_at(4 * NUMBERS_OF_BOX * line.ranked);
        let scores = finite("detection", scores)?;
        let ranked_scores = finite("ranked box", ranked_scores)?;
        let box_scores = words(box_scores).map(f32::from_le_bytes).enumerate().map(|(idx, it)| match it {
            it if it.is_infinite() => Err(format!("the box score of detection {idx} is {it}")),
            it => Ok((!it.is_nan()).then_some(it)),
        });
        let values = products.chunks_exact(n_points.max(1)).map(<[u8]>::to_vec);
        // A scan without points has products without values.
        let values = values.chain(std::iter::repeat_with(Vec::new));
        Ok(Self {
            clusters,
            boxes,
            scores: line.scores.then_some(scores),
            box_scores: box_scores.collect::<Result<Vec<_>, _>>()?,
            velocities: velocities_of(velocities)?,
            tracks: words(tracks).map(u32::from_le_bytes).map(|it| (it != NO_TRACK).then_some(it)).collect(),
            ranked: boxes_of("ranked box", ranked)?
                .into_iter()
                .zip(ranked_scores)
                .zip(classes_of(line.ranked_classes.as_deref(), "ranked boxes", line.ranked, table)?)
                .map(|((bounding_box, score), class)| RankedBox { bounding_box, score, class })
                .collect(),
            classes: classes_of(line.classes.as_deref(), "detections", n_detections, table)?,
            names_classes: line.classes.is_some(),
            stages: line.stages.iter().map(|it| (it.name.clone(), it.ms)).collect(),
            products: line.products.iter().map(|it| it.name.clone()).zip(values).collect(),
        })
    }
}

impl Parts {
    fn of(line: &ResultLine, n_points: usize) -> Self {
        Self {
            ids: if line.clusters { 4 * n_points } else { 0 },
            boxes: 4 * NUMBERS_OF_BOX * line.n_boxes,
            ranked: 4 * (NUMBERS_OF_BOX + 1) * line.ranked,
            products: line.products.len() * n_points,
        }
    }
}

/// Bytes of each detection: of its score, the score of its box, its velocity and its track.
fn bytes_of_detection(line: &ResultLine) -> [usize; 4] {
    [(line.scores, 4), (line.box_scores, 4), (line.velocities, 8), (line.tracks, 4)]
        .map(|(is_there, n_bytes)| if is_there { n_bytes } else { 0 })
}

fn velocities_of(bytes: &[u8]) -> Result<Vec<Option<[f32; 2]>>, String> {
    let velocities = bytes.as_chunks::<8>().0.iter().enumerate().map(|(idx, it)| {
        let mut along = words(it).map(f32::from_le_bytes);
        match [(); 2].map(|()| along.next().unwrap_or_default()) {
            [x, y] if x.is_nan() && y.is_nan() => Ok(None),
            [x, y] if x.abs() <= FASTEST_M_PER_S && y.abs() <= FASTEST_M_PER_S => Ok(Some([x, y])),
            other => Err(format!(
                "the velocity of detection {idx} is {other:?} m/s: known along one axis alone, or above {FASTEST_M_PER_S}"
            )),
        }
    });
    velocities.collect()
}

fn words(bytes: &[u8]) -> impl Iterator<Item = [u8; 4]> {
    bytes.as_chunks::<4>().0.iter().copied()
}

/// Scores, one for each `what`.
fn finite(what: &str, bytes: &[u8]) -> Result<Vec<f32>, String> {
    let scores: Vec<f32> = words(bytes).map(f32::from_le_bytes).collect();
    match scores.iter().enumerate().find(|(_, it)| !it.is_finite()) {
        Some((idx, score)) => Err(format!("the score of {what} {idx} is {score}")),
        None => Ok(scores),
    }
}

/// Boxes, each a `what`.
fn boxes_of(what: &str, bytes: &[u8]) -> Result<Vec<OrientedBox>, String> {
    let boxes = bytes.chunks_exact(4 * NUMBERS_OF_BOX).map(box_of).enumerate();
    boxes.map(|(idx, it)| it.map_err(|problem| format!("{what} {idx} has {problem}"))).collect()
}

fn box_of(bytes: &[u8]) -> Result<OrientedBox, String> {
    let mut numbers = [0.0; NUMBERS_OF_BOX];
    for (number, bytes) in numbers.iter_mut().zip(words(bytes)) {
        *number = f32::from_le_bytes(bytes);
    }
    let [x_m, y_m, z_m, length_m, width_m, height_m, yaw_rad] = numbers;
    let (center_m, length_width_height_m) = ([x_m, y_m, z_m], [length_m, width_m, height_m]);
    let problem = if !numbers.iter().all(|it| it.is_finite()) {
        format!("{numbers:?}, not all of them finite")
    } else if !length_width_height_m.iter().all(|it| *it > 0.0 && *it <= LONGEST_SIDE_M) {
        format!("the size {length_width_height_m:?} m, not above 0 and at most {LONGEST_SIDE_M}")
    } else if !center_m.iter().all(|it| it.abs() <= FARTHEST_M) {
        format!("the centre {center_m:?} m, more than {FARTHEST_M} from the sensor")
    } else {
        // Any yaw is allowed; larger ones are reduced to one turn.
        let yaw_rad = if yaw_rad.abs() <= std::f32::consts::TAU {
            yaw_rad
        } else {
            (f64::from(yaw_rad) % std::f64::consts::TAU) as f32
        };
        return Ok(OrientedBox { center_m, length_width_height_m, yaw_rad });
    };
    Err(problem)
}

/// Number of detections that clusters and boxes make.
fn n_detections(clusters: Option<&[u32]>, n_boxes: usize) -> Result<usize, String> {
    let Some(clusters) = clusters else { return Ok(n_boxes) };
    if n_boxes == 0 {
        let mut ids: Vec<u32> = clusters.iter().copied().filter(|it| *it > 0).collect();
        ids.sort_unstable();
        ids.dedup();
        return Ok(ids.len());
    }
    let largest = clusters.iter().copied().max().unwrap_or(0) as usize;
    if largest != n_boxes {
        return Err(format!("the largest cluster id is {largest}, but there are {n_boxes} boxes"));
    }
    Ok(n_boxes)
}

/// The `written` classes of `n` things, which are `what`.
fn classes_of(
    written: Option<&[Option<String>]>,
    what: &str,
    n: usize,
    table: &ClassTable,
) -> Result<Vec<Option<ForeignClass>>, String> {
    let Some(written) = written else { return Ok(vec![None; n]) };
    if written.len() != n {
        return Err(format!("there are {} classes of {n} {what}", written.len()));
    }
    let class = |word: &str| Ok(ForeignClass::of(word, table.class_of_detection(word)?));
    written.iter().map(|it| it.as_deref().map(class).transpose()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use reports::vocabulary::class::AnnotationClass;

    use super::super::message::ProductLine;

    fn line(n_boxes: usize, clusters: bool, scores: bool) -> ResultLine {
        ResultLine { number: 1, clusters, n_boxes, scores, ..ResultLine::default() }
    }

    fn read(line: &ResultLine, payload: &[u8], n_points: usize) -> Result<Found, String> {
        Found::check_line(line, payload.len(), n_points)?;
        Found::read(line, payload, n_points, &ClassTable::default())
    }

    fn ids(ids: &[u32]) -> Vec<u8> {
        ids.iter().flat_map(|it| it.to_le_bytes()).collect()
    }

    fn numbers(numbers: &[f32]) -> Vec<u8> {
        numbers.iter().flat_map(|it| it.to_le_bytes()).collect()
    }

    const CAR: [f32; 7] = [8.0, 3.0, -1.0, 4.2, 1.8, 1.5, 0.25];

    #[test]
    fn parts_are_found_where_the_protocol_has_them() {
        let mut line = line(2, true, true);
        line.classes = Some(vec![Some("car".to_owned()), None]);
        line.products.push(ProductLine {
            name: "ground".to_owned(),
            kind: "point-labels".to_owned(),
            value: "u8".to_owned(),
        });
        let payload =
            [ids(&[1, 0, 2]), numbers(&CAR), numbers(&CAR), numbers(&[0.5, -2.0]), vec![7, 8, 9]].concat();
        let found = read(&line, &payload, 3).unwrap();
        assert_eq!(found.clusters, Some(vec![1, 0, 2]));
        assert_eq!((found.boxes.len(), found.boxes[1].yaw_rad), (2, 0.25));
        assert_eq!(found.scores, Some(vec![0.5, -2.0]));
        assert_eq!(found.classes, [Some(AnnotationClass::Car.into()), None]);
        assert_eq!(found.products, [("ground".to_owned(), vec![7, 8, 9])]);
    }

    #[test]
    fn clusters_alone_have_a_score_for_each_id_that_occurs() {
        let payload = [ids(&[9, 0, 4, 9]), numbers(&[0.1, 0.2])].concat();
        assert_eq!(read(&line(0, true, true), &payload, 4).unwrap().scores, Some(vec![0.1, 0.2]));
        let problem = read(&line(0, true, true), &payload[..20], 4).unwrap_err();
        assert!(problem.contains("payload_bytes is 20, but 2 detections make 24"), "{problem}");
    }

    #[test]
    fn ranked_boxes_and_scores_of_boxes_stand_behind_the_scores() {
        let mut line = line(2, true, true);
        (line.box_scores, line.ranked) = (true, 1);
        let payload = |box_score: f32, ranked: f32| {
            let scores = [0.5, -2.0, box_score, f32::NAN];
            [
                ids(&[1, 0, 2]),
                numbers(&CAR),
                numbers(&CAR),
                numbers(&scores),
                numbers(&CAR),
                numbers(&[ranked]),
            ]
            .concat()
        };
        let found = read(&line, &payload(0.75, -3.0), 3).unwrap();
        assert_eq!(found.box_scores, [Some(0.75), None]);
        let ranked = RankedBox { bounding_box: found.boxes[0], score: -3.0, class: None };
        assert_eq!(found.ranked, [ranked]);
        line.ranked_classes = Some(vec![Some("pedestrian".to_owned())]);
        let class = Some(AnnotationClass::Pedestrian.into());
        assert_eq!(read(&line, &payload(0.75, -3.0), 3).unwrap().ranked, [RankedBox { class, ..ranked }]);
        line.ranked_classes = Some(Vec::new());
        let problem = read(&line, &payload(0.75, -3.0), 3).unwrap_err();
        assert_eq!(problem, "there are 0 classes of 1 ranked boxes");
        line.ranked_classes = None;
        for (payload, expected) in [
            (payload(f32::INFINITY, 0.0), "the box score of detection 0 is inf"),
            (payload(0.0, f32::NAN), "the score of ranked box 0 is NaN"),
            (
                payload(0.0, 0.0)[4..].to_vec(),
                "2 boxes, cluster ids, scores, box scores, 1 ranked boxes make 116",
            ),
        ] {
            let problem = read(&line, &payload, 3).unwrap_err();
            assert!(problem.contains(expected), "{problem}");
        }
        line.ranked = MOST_BOXES + 1;
        assert!(read(&line, &[], 3).unwrap_err().contains("ranked is 100001"));
    }

    #[test]
    fn velocities_and_tracks_stand_behind_the_scores() {
        let mut line = line(0, true, true);
        (line.velocities, line.tracks) = (true, true);
        let payload = |velocity: [f32; 2]| {
            let motion = [velocity[0], velocity[1], f32::NAN, f32::NAN];
            [ids(&[4, 0, 9]), numbers(&[0.5, -2.0]), numbers(&motion), ids(&[7, NO_TRACK])].concat()
        };
        let found = read(&line, &payload([-3.5, 0.25]), 3).unwrap();
        assert_eq!(found.velocities, [Some([-3.5, 0.25]), None]);
        assert_eq!(found.tracks, [Some(7), None]);
        assert_eq!(found.scores, Some(vec![0.5, -2.0]));
        for velocity in [[f32::NAN, 0.0], [f32::INFINITY, 0.0], [0.0, -1001.0]] {
            let problem = read(&line, &payload(velocity), 3).unwrap_err();
            assert!(problem.contains("the velocity of detection 0 is"), "{problem}");
        }
        let problem = read(&line, &payload([0.0; 2])[..40], 3).unwrap_err();
        assert!(problem.contains("payload_bytes is 40, but 2 detections make 44"), "{problem}");
    }

    #[test]
    fn nothing_is_a_found_nothing() {
        let found = read(&line(0, false, false), &[], 100).unwrap();
        assert_eq!(found, Found::default());
        assert_eq!(read(&line(0, true, false), &[], 0).unwrap().clusters, Some(vec![]));
    }

    #[test]
    fn wrong_lengths_and_numbers_are_refused() {
        let with = |index: usize, number: f32| {
            let mut of_box = CAR;
            of_box[index] = number;
            read(&line(1, false, false), &numbers(&of_box), 0).unwrap_err()
        };
        for (problem, expected) in [
            (with(0, f32::NAN), "not all of them finite"),
            (with(6, f32::INFINITY), "not all of them finite"),
            (with(2, 10_001.0), "more than 10000 from the sensor"),
            (with(3, 0.0), "not above 0"),
            (with(5, 1001.0), "at most 1000"),
            (
                read(&line(0, true, false), &ids(&[1, 2]), 3).unwrap_err(),
                "payload_bytes is 8, but 3 points, 0 boxes, cluster ids make 12",
            ),
            (read(&line(MOST_BOXES + 1, false, false), &[], 0).unwrap_err(), "more than 100000"),
            (
                read(&line(1, true, false), &[ids(&[2]), numbers(&CAR)].concat(), 1).unwrap_err(),
                "the largest cluster id is 2",
            ),
            (
                read(&line(1, false, true), &numbers(&[&CAR[..], &[f32::NAN]].concat()), 0).unwrap_err(),
                "score of detection 0 is NaN",
            ),
        ] {
            assert!(problem.contains(expected), "{problem}");
        }
        let mut line = line(1, false, false);
        line.classes = Some(vec![Some("spaceship".to_owned())]);
        assert!(read(&line, &numbers(&CAR), 0).unwrap_err().contains("\"spaceship\" is not a class"));
        line.classes = Some(vec![]);
        assert!(read(&line, &numbers(&CAR), 0).unwrap_err().contains("0 classes of 1 detections"));
    }

    #[test]
    fn a_turn_of_many_rounds_is_one_within_a_round() {
        let mut of_box = CAR;
        of_box[6] = 0.5 + 20.0 * std::f32::consts::TAU;
        let found = read(&line(1, false, false), &numbers(&of_box), 0).unwrap();
        assert!((found.boxes[0].yaw_rad - 0.5).abs() < 1e-4);
    }
}
