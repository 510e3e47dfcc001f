//! `--blocks`: a file that says which scans of a data set belong together.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use reports::files::csv_rows::{CsvRow, each_row_of};
use reports::files::regular_file::read_settings;
use scans::annotation::ScanId;
use scans::dataset::checksum::sha256;
use scans::dataset::shown_name::is_printable;
use serde::{Deserialize, Serialize};

use crate::plumbing::counted_dataset::CountedDataset;
use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::open_datasets::OpenedDataset;

#[derive(Debug, Clone, Serialize, Deserialize)]
struct BlockRow {
    scan: String,
    block: String,
}

impl CsvRow for BlockRow {
    const COLUMNS: &'static [&'static str] = &["scan", "block"];
}

/// `datasets`, with the blocks that `file` names, if there is one. Scans of a block come one after the other, so that shards
/// can be cut between blocks.
pub fn with_named_blocks(
    datasets: Vec<OpenedDataset>,
    file: Option<&Path>,
) -> Result<Vec<OpenedDataset>, Failure> {
    let Some(path) = file else { return Ok(datasets) };
    let n_datasets = datasets.len();
    let Ok([opened]) = <[OpenedDataset; 1]>::try_from(datasets) else {
        let problem = format!("--blocks is about the scans of one data set, and {n_datasets} are given");
        return Err(Usage(problem).into());
    };
    let cannot_use = |source| Failure::usage(format!("cannot use the blocks of {path:?}"), source);
    let content =
        read_settings(path).map_err(|error| Failure::usage(format!("cannot read {path:?}"), error))?;
    let mut rows: Vec<BlockRow> = Vec::new();
    each_row_of(&content[..], path, |row| rows.push(row)).map_err(cannot_use)?;
    let scan_ids = opened.dataset.scan_ids();
    let blocks =
        blocks_of(&rows, scan_ids, &opened.scan_indices).map_err(|it| Usage(format!("{path:?}{it}")))?;
    let mut scan_indices = opened.scan_indices;
    let mut indices: HashMap<&Option<String>, usize> = HashMap::new();
    for (index, scan_idx) in scan_indices.iter().enumerate() {
        indices.entry(&blocks[*scan_idx]).or_insert(index);
    }
    scan_indices.sort_by_key(|it| indices[&blocks[*it]]);
    Ok(vec![OpenedDataset {
        dataset: Box::new(CountedDataset::with_blocks(opened.dataset, blocks)),
        scan_indices,
        blocks_checksum: Some(sha256(content)),
        ..opened
    }])
}

/// The block of each of `scan_ids`; those not among `scan_indices` may have none. The file may also name scans that do not
/// exist.
fn blocks_of(
    rows: &[BlockRow],
    scan_ids: &[ScanId],
    scan_indices: &[usize],
) -> Result<Vec<Option<String>>, String> {
    let mut by_number: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (scan_idx, id) in scan_ids.iter().enumerate() {
        by_number.entry(id.index).or_default().push(scan_idx);
    }
    let mut blocks: Vec<Option<(String, usize)>> = vec![None; scan_ids.len()];
    // The first line has the names of the columns.
    for (line, BlockRow { scan, block }) in (2..).zip(rows) {
        let (sequence, number) = scan.rsplit_once('/').map_or((None, &scan[..]), |it| (Some(it.0), it.1));
        let number: u32 = number.trim().parse().map_err(|_| {
            format!(", line {line}: {scan:?} is no name of a scan; write it as {}", example(scan_ids))
        })?;
        if block.is_empty() || !block.chars().all(is_printable) {
            return Err(format!(", line {line}: {block:?} is no name of a block"));
        }
        let is_meant = |it: &&usize| sequence.is_none_or(|sequence| sequence == scan_ids[**it].sequence);
        let meant: Vec<usize> =
            by_number.get(&number).into_iter().flatten().filter(is_meant).copied().collect();
        match meant[..] {
            [] => {}
            [scan_idx] => {
                if let Some((_, before)) = &blocks[scan_idx] {
                    return Err(format!(
                        ", line {line}: scan {} is in line {before} already",
                        scan_ids[scan_idx]
                    ));
                }
                blocks[scan_idx] = Some((block.clone(), line));
            }
            [first, second, ..] => {
                let (first, second) = (&scan_ids[first], &scan_ids[second]);
                return Err(format!(
                    ", line {line}: several scans are called {scan:?}, such as {first} and {second}"
                ));
            }
        }
    }
    let missing: Vec<&ScanId> =
        scan_indices.iter().filter(|it| blocks[**it].is_none()).map(|it| &scan_ids[*it]).collect();
    match missing[..] {
        [] => Ok(blocks.into_iter().map(|it| it.map(|it| it.0)).collect()),
        [only] => Err(format!(" has no block for scan {only}")),
        [first, ..] => Err(format!(" has no block for {} scans, such as {first}", missing.len())),
    }
}

fn example(scan_ids: &[ScanId]) -> String {
    scan_ids.first().map_or_else(String::new, ToString::to_string)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blocks(lines: &[[&str; 2]]) -> Result<Vec<Option<String>>, String> {
        let id = |sequence: &str, index| ScanId { sequence: sequence.to_owned(), index };
        let row = |it: &[&str; 2]| BlockRow { scan: it[0].to_owned(), block: it[1].to_owned() };
        let rows: Vec<BlockRow> = lines.iter().map(row).collect();
        // The last is not taken.
        blocks_of(&rows, &[id("a", 1), id("a", 7), id("b", 7), id("b", 9)], &[0, 1, 2])
    }

    #[test]
    fn every_scan_that_is_taken_has_its_block() {
        let found = blocks(&[["b/7", "y"], ["000001", "x"], ["a/000007", "x"], ["c/000003", "z"]]).unwrap();
        assert_eq!(found, [Some("x"), Some("x"), Some("y"), None].map(|it| it.map(str::to_owned)));
    }

    #[test]
    fn what_is_missing_or_twice_is_refused_with_its_line() {
        let whole = [["a/1", "x"], ["a/7", "x"], ["b/7", "y"]];
        for (more, expected) in [
            (["a/000001", "y"], ", line 5: scan a/000001 is in line 2 already"),
            (["7", "y"], ", line 5: several scans are called \"7\", such as a/000007 and b/000007"),
            (["first", "y"], ", line 5: \"first\" is no name of a scan; write it as a/000001"),
            (["b/9", ""], ", line 5: \"\" is no name of a block"),
        ] {
            assert_eq!(blocks(&[&whole[..], &[more]].concat()).unwrap_err(), expected);
        }
        assert_eq!(blocks(&whole[..2]).unwrap_err(), " has no block for scan b/000007");
        assert_eq!(blocks(&whole[..1]).unwrap_err(), " has no block for 2 scans, such as a/000007");
    }
}
