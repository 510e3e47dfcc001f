//! The messages, as JSON.

use serde::{Deserialize, Serialize};

/// Versions of the protocol that this program speaks.
pub const PROTOCOLS: [u32; 2] = [1, 2];
/// Longest line of a message in bytes, with its end.
pub const MOST_LINE_BYTES: usize = 1 << 20;
/// Extension of the protocol that lets answers have scores of boxes, and boxes that are only ranked.
pub const RANKED: &str = "ranked";
/// Most earlier scans that a detector may ask for.
pub const MOST_EARLIER_SCANS: usize = 100;
/// Stands for no track.
pub const NO_TRACK: u32 = u32::MAX;
/// Most boxes of an answer.
pub const MOST_BOXES: usize = scans::foreign::detections::MAX_BOXES;

/// A message from the host to the detector.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(tag = "message", rename_all = "lowercase")]
pub enum Question {
    /// The first message.
    Hello {
        /// Oldest version of the protocol that this program speaks.
        protocol: u32,
        /// All versions that it speaks.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        protocols: Vec<u32>,
        /// Name and version of this program.
        program: String,
        /// Extensions of the first version of the protocol that answers may use.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        extensions: Vec<String>,
    },
    /// The configuration to use.
    Configure(Configuration),
    /// A scan in which to detect objects.
    Scan(AskedScan),
    /// The detector has to end.
    Quit,
}

/// Configuration of a detector.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Configuration {
    /// Id of the data set.
    pub dataset: String,
    /// The sensor, if known.
    pub sensor: Option<String>,
    /// Height of the sensor above the ground, in metres.
    pub sensor_height_m: Option<f32>,
    /// The user's values.
    pub parameters: serde_json::Map<String, serde_json::Value>,
    /// How many threads to use at most.
    pub threads: u32,
    /// No scan has more points.
    pub max_points: usize,
    /// File to map for reading.
    pub shared_memory: String,
}

/// A scan in the shared memory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AskedScan {
    /// Repeated in the answer.
    pub number: u64,
    /// Drive, slash, scan.
    pub name: String,
    /// Seconds within its drive.
    pub time_s: f64,
    /// Length of each column.
    pub n_points: usize,
    /// Where the columns are.
    pub columns: Vec<Column>,
    /// Whether the scan before was of another drive, or this one has been sent before. From here on only in version 2.
    #[serde(default, skip_serializing_if = "is_false")]
    pub begins_drive: bool,
    /// Pose of the sensor in a frame that rests, if known: three rows of four numbers, the turn and the position.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub world_from_sensor: Option<[f64; 12]>,
    /// The scans before it, the latest first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub earlier: Vec<AskedEarlierScan>,
}

/// A scan before the one that is asked for, in its frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AskedEarlierScan {
    /// Drive, slash, scan.
    pub name: String,
    /// Seconds within its drive.
    pub time_s: f64,
    /// Length of each column.
    pub n_points: usize,
    /// Where the columns are.
    pub columns: Vec<Column>,
}

/// A column of the points.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Column {
    /// Its quantity, such as `x_m`.
    pub name: String,
    /// Type of its numbers.
    #[serde(rename = "type")]
    pub kind: String,
    /// Where it begins, in bytes.
    pub offset: usize,
}

/// A message from the detector to the host.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(tag = "message", rename_all = "lowercase")]
pub enum Answer {
    /// To `hello`.
    Hello(Introduction),
    /// To `configure`.
    Configured(Wishes),
    /// To `scan`.
    Result(ResultLine),
    /// To anything that failed.
    Error {
        /// Why.
        text: String,
    },
}

/// How a detector introduces itself.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Introduction {
    /// Version of the protocol.
    pub protocol: u32,
    /// Its name.
    pub name: String,
    /// Its version.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub version: Option<String>,
}

/// What a detector asks for with every scan.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Wishes {
    /// So many scans before it.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub earlier_scans: usize,
    /// The scans of a drive one after the other, each once.
    #[serde(default, skip_serializing_if = "is_false")]
    pub in_order: bool,
}

/// A result without its payload.
#[expect(clippy::struct_excessive_bools, reason = "the payload has many parts")]
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ResultLine {
    /// Number of the scan.
    pub number: u64,
    /// The payload has a cluster id for each point.
    #[serde(default)]
    pub clusters: bool,
    /// Boxes in the payload.
    #[serde(default)]
    pub n_boxes: usize,
    /// The payload has a score for each detection.
    #[serde(default)]
    pub scores: bool,
    /// The payload has a score of the box of each detection.
    #[serde(default, skip_serializing_if = "is_false")]
    pub box_scores: bool,
    /// The payload has a velocity of each detection.
    #[serde(default, skip_serializing_if = "is_false")]
    pub velocities: bool,
    /// The payload has the track of each detection.
    #[serde(default, skip_serializing_if = "is_false")]
    pub tracks: bool,
    /// Boxes that are only ranked.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub ranked: usize,
    /// The class of each box that is only ranked; vehicles if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ranked_classes: Option<Vec<Option<String>>>,
    /// The class of each detection; all `None` if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub classes: Option<Vec<Option<String>>>,
    /// Stage times that the detector measured.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stages: Vec<ReportedStage>,
    /// Products that are drawn beside the detections.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub products: Vec<ProductLine>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde wants a reference")]
fn is_false(it: &bool) -> bool {
    !it
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde wants a reference")]
fn is_zero(it: &usize) -> bool {
    *it == 0
}

/// Time of a stage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ReportedStage {
    /// Its name.
    pub name: String,
    /// In milliseconds.
    pub ms: f64,
}

/// Description of a product.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProductLine {
    /// Its name.
    pub name: String,
    /// How it is drawn.
    pub kind: String,
    /// Type of its numbers.
    #[serde(rename = "type")]
    pub value: String,
}

/// The line of a message with `payload_bytes`, and its end.
///
/// # Errors
///
/// If `message` cannot be written as JSON.
pub fn line_of<M: Serialize>(message: &M, n_payload_bytes: usize) -> Result<Vec<u8>, serde_json::Error> {
    let mut value = serde_json::to_value(message)?;
    if let (Some(fields), 1..) = (value.as_object_mut(), n_payload_bytes) {
        fields.insert("payload_bytes".to_owned(), n_payload_bytes.into());
    }
    let mut line = serde_json::to_vec(&value)?;
    line.push(b'\n');
    Ok(line)
}

/// The message on `line`, and how many bytes follow it.
///
/// # Errors
///
/// The problem with the line.
pub fn parse_line<M: for<'a> Deserialize<'a>>(line: &[u8]) -> Result<(M, usize), String> {
    let value: serde_json::Value =
        serde_json::from_slice(line).map_err(|error| format!("a line is not JSON: {error}"))?;
    if !value.is_object() {
        return Err("a line is not a JSON object".to_owned());
    }
    let n_payload_bytes = match value.get("payload_bytes") {
        None => 0,
        Some(number) => {
            let number_read = number.as_u64().and_then(|it| usize::try_from(it).ok());
            number_read.ok_or_else(|| format!("payload_bytes is {number}, not a number of bytes"))?
        }
    };
    let message = serde_json::from_value(value).map_err(|error| format!("a message is wrong: {error}"))?;
    Ok((message, n_payload_bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_read_back_as_they_were() {
        let line = ResultLine { number: 3, clusters: true, ..ResultLine::default() };
        let written = line_of(&Answer::Result(line.clone()), 48).unwrap();
        assert_eq!(written.last(), Some(&b'\n'));
        let (Answer::Result(read), 48) = parse_line(&written).unwrap() else { panic!("{written:?}") };
        assert_eq!(read, line);
    }

    #[test]
    fn unknown_fields_are_ignored_and_missing_ones_are_not() {
        let parse = |line: &str| parse_line::<Answer>(line.as_bytes());
        assert!(parse(r#"{"message":"configured","colour":"red"}"#).is_ok());
        let refused = [
            (r#"{"message":"result"}"#, "missing field `number`"),
            (r#"{"message":"results","number":1}"#, "unknown variant `results`"),
            (r#"{"number":1}"#, "missing field `message`"),
            (r#"["message"]"#, "not a JSON object"),
            (r#"{"message":"configured","payload_bytes":-1}"#, "payload_bytes is -1"),
            ("{", "not JSON"),
        ];
        for (line, expected) in refused {
            let problem = parse(line).unwrap_err();
            assert!(problem.contains(expected), "{line}: {problem}");
        }
    }
}
