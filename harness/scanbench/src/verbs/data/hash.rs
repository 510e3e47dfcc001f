//! `scanbench data hash`.

use std::path::Path;

use reports::files::whole_file::WholeFile;
use scans::dataset::catalogue::parse_catalogue;
use scans::dataset::class_table::whatever_classes;
use scans::dataset::text_file::read_text_file;
use simulator::catalogue::Catalogue;
use simulator::open::{OpenOptions, open_dataset};
use simulator::simulated_street::StreetDrive;

use crate::cli::HashArgs;
use crate::plumbing::config::classes_of_project;
use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::open_datasets::open_catalogue;
use crate::plumbing::remote::local_name;
use crate::plumbing::standard_streams::print_result;

/// Prints the checksums of data sets, and writes them into the catalogue if asked to.
pub fn data_hash(arguments: &HashArgs) -> Result<(), Failure> {
    let path = arguments.catalogue.catalogue.as_deref();
    // A catalogue may name classes of the user.
    classes_of_project()?;
    let mut catalogue = open_catalogue(path)?;
    let mut text = match path {
        Some(path) if arguments.write => Some((path, read_text_file(path)?)),
        _ => None,
    };
    for name in &arguments.datasets {
        let checksum = checksum_of(name, &mut catalogue)?;
        print_result(format_args!("{name}  {checksum}"))?;
        if let Some((_, text)) = &mut text {
            *text = with_checksum(text, name, &checksum)
                .ok_or_else(|| Usage(format!("the catalogue has no [recorded.{name}]")))?;
        }
    }
    match text {
        Some((path, text)) => write(path, &text),
        None => Ok(()),
    }
}

/// The checksum of the files as they are, whatever the catalogue says.
fn checksum_of(name: &str, catalogue: &mut Catalogue) -> Result<String, Failure> {
    if let Some(entry) = catalogue.recorded.get_mut(name) {
        entry.checksum = None;
    }
    let dataset = open_dataset(
        &local_name(name, None)?,
        &OpenOptions { classes: whatever_classes(), ..OpenOptions::default() },
        catalogue,
    )?;
    let checksum = dataset.description().checksum.clone();
    checksum.ok_or_else(|| Usage(format!("{name:?} has no checksum")).into())
}

/// `text` with the checksum in the entry `[recorded.ID]`; `None` if there is none. Everything else stays as it is.
fn with_checksum(text: &str, id: &str, checksum: &str) -> Option<String> {
    let heading = format!("[recorded.{id}]");
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let begin = lines.iter().position(|line| line.trim() == heading)? + 1;
    let n_lines = lines[begin..].iter().take_while(|line| !line.trim_start().starts_with('[')).count();
    let is_checksum = |line: &String| line.split('=').next().is_some_and(|key| key.trim() == "checksum");
    let line = format!("checksum = \"{checksum}\"");
    let entry = &lines[begin..begin + n_lines];
    if let Some(index) = entry.iter().position(is_checksum) {
        lines[begin + index] = line;
    } else {
        let is_filled = |line: &String| !line.trim().is_empty() && !line.trim_start().starts_with('#');
        let n_filled = entry.iter().rposition(is_filled).map_or(0, |index| index + 1);
        lines.insert(begin + n_filled, line);
    }
    Some(lines.join("\n") + "\n")
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    use std::io::Write as _;
    // The edited text must still be a catalogue.
    parse_catalogue::<StreetDrive>(&path.display().to_string(), text)?;
    let mut file = WholeFile::create(path)?;
    file.write_all(text.as_bytes()).map_err(|error| Failure::of_writing(error.kind(), error))?;
    file.finish()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "# mine\n[recorded.a]\nroot = \"/a\"\n\n# the other\n[recorded.b]\nroot = \"/b\"\nchecksum = \"old\"\n";

    #[test]
    fn a_checksum_is_put_in_its_entry() {
        let expected = TEXT.replace("\"/a\"\n", "\"/a\"\nchecksum = \"12ab\"\n");
        assert_eq!(with_checksum(TEXT, "a", "12ab").unwrap(), expected);
        assert_eq!(with_checksum(TEXT, "b", "12ab").unwrap(), TEXT.replace("old", "12ab"));
        assert_eq!(with_checksum(TEXT, "c", "12ab"), None);
    }
}
