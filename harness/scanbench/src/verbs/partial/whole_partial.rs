//! Result of all objects of `scanbench partial`, made of the rows of shards.

use evaluation::partial::methods::OURS;
use reports::files::csv_rows::{read_rows, to_csv_bytes};
use reports::pages::partial_page::PartialPage;
use reports::rows::partial_row::PartialRow;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::{PARTIAL_CSV, RunDirectory};
use reports::vocabulary::study::Study;

use crate::plumbing::failure::{Failure, NothingEvaluated};
use crate::plumbing::shards::executor::WholeResult;
use crate::plumbing::shards::shard_log::ShardLog;
use crate::plumbing::shards::whole_manifest::{Pieces, merged_manifest};
use crate::verbs::partial::files::write_files;
use crate::verbs::partial::object_event::ObjectRows;

/// A result whose files are all written.
pub struct WholePartial {
    /// The table that is printed.
    pub printed: String,
}

impl WholeResult for WholePartial {
    fn of_shards(
        _: Study,
        shards: &[ShardLog<'_>],
        manifests: &[&Manifest],
        directory: &RunDirectory,
    ) -> Result<Self, Failure> {
        let pieces = shards[0].pieces();
        let mut manifest = merged_manifest(manifests, directory.target(), pieces);
        if pieces == Pieces::One {
            manifest.shards.clear();
        }
        let mut rows: Vec<PartialRow> = Vec::new();
        for shard in shards {
            let mut of_shard = ObjectRows::default();
            shard.each_event(|event| {
                of_shard.add(event);
                Ok(())
            })?;
            rows.extend(of_shard.finish());
        }
        if rows.is_empty() {
            return Err(
                NothingEvaluated { reason: "no object is of a class that is judged".to_owned() }.into()
            );
        }
        let rows = if pieces == Pieces::One { rows } else { in_order_of_whole(rows) };
        directory.write_file(PARTIAL_CSV, &to_csv_bytes(&rows)?)?;
        // As they are written, with as many decimals: the file leads to the same numbers.
        let rows: Vec<PartialRow> = read_rows(&directory.path_of(PARTIAL_CSV))?;
        let printed = write_files(directory, &manifest, &rows)?;
        PartialPage::of(directory.folder(), OURS)?.write(directory.folder())?;
        Ok(Self { printed })
    }
}

/// Rows set by set, and within a set the answers of one method after those of another. Shards have the sets and the methods
/// in the same order.
fn in_order_of_whole(rows: Vec<PartialRow>) -> Vec<PartialRow> {
    let mut groups: Vec<Vec<PartialRow>> = Vec::new();
    for row in rows {
        match groups.iter_mut().find(|it| it.first().is_some_and(|it| it.is_of_same_answers(&row))) {
            Some(group) => group.push(row),
            None => groups.push(vec![row]),
        }
    }
    groups.into_iter().flatten().collect()
}
