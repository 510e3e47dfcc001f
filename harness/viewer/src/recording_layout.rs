//! What the layer of the layout says beside the blueprint, so that detectors can join a recording: its id, and what its
//! detectors draw. Nothing else is read back from a recording.

use std::io::BufReader;
use std::path::Path;

use re_sdk_types::archetypes::TextDocument;
use reports::files::regular_file::RegularFile;
use rerun::external::arrow::array::{Array as _, AsArray as _};
use rerun::external::re_log_encoding::DecoderApp;
use rerun::external::re_log_types::LogMsg;
use rerun::log::Chunk;
use rerun::{EntityPath, RecordingStream, StoreId};

use super::error::StreamError;
use super::product_views::DetectorOutline;

/// The property that holds the detectors, as JSON.
const PROPERTY: &str = "detectors";

/// What is read of a layout.
pub struct KeptLayout {
    /// Id of the recording that its layers are of.
    pub store: StoreId,
    /// The detectors, in the order in which they are shown.
    pub detectors: Vec<DetectorOutline>,
}

/// Keeps what `detectors` draw in the layer `stream`.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn keep(stream: &RecordingStream, detectors: &[DetectorOutline]) -> Result<(), StreamError> {
    let json = serde_json::to_string(detectors).expect("names are text");
    let kept = stream.send_property(PROPERTY, &TextDocument::new(json));
    kept.map_err(|error| StreamError::Log { entity: PROPERTY.to_owned(), reason: error.to_string() })
}

impl KeptLayout {
    /// Reads the layer at `path`.
    ///
    /// # Errors
    ///
    /// [`StreamError::NoLayout`] if it cannot be read, or was written by another version.
    pub fn read(path: &Path) -> Result<Self, StreamError> {
        let refused = |reason: &dyn ToString| StreamError::NoLayout {
            path: path.to_owned(),
            reason: reason.to_string(),
        };
        let file = RegularFile::open(path).map_err(|error| refused(&error))?;
        let messages = DecoderApp::decode_eager(BufReader::new(file)).map_err(|error| refused(&error))?;
        for message in messages {
            let LogMsg::ArrowMsg(store, message) = message.map_err(|error| refused(&error))? else {
                continue;
            };
            let chunk = Chunk::from_arrow_msg(&message).map_err(|error| refused(&error))?;
            if store.is_recording() && *chunk.entity_path() == EntityPath::properties().join(&PROPERTY.into())
            {
                let text = TextDocument::descriptor_text().component;
                let json = chunk
                    .components()
                    .get_array(text)
                    .filter(|it| !it.is_empty())
                    .map(|it| it.value(0))
                    .ok_or("it is empty");
                let json = json.map_err(|error| refused(&error))?;
                let json = json.as_string_opt::<i32>().filter(|it| it.len() == 1).map(|it| it.value(0));
                let detectors =
                    serde_json::from_str(json.unwrap_or_default()).map_err(|error| refused(&error))?;
                return Ok(Self { store, detectors });
            }
        }
        Err(refused(&"it does not say what its detectors draw"))
    }
}
