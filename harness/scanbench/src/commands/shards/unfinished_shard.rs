//! A shard that is being made: its place, what it has done so far, and what it becomes.

use std::path::{Path, PathBuf};
use std::time::Duration;

use evaluation::journal::{Journal, JournalIdentity, JournalKind, OtherJournal};
use jiff::Timestamp;
use reports::files::archive::ArchiveError;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::{ClaimedTarget, MANIFEST_JSON};
use reports::run_folder::shard_record::ShardRecord;
use reports::vocabulary::shard::Shard;
use reports::vocabulary::study::Study;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::finished_shard::finished_shard;
use super::share_of_work::ShareOfWork;
use crate::cli::OutputArgs;
use crate::commands::failure::{Failure, Usage};
use crate::commands::interruption::{set_grace, set_last_words};
use crate::commands::provenance::{program_checksum, rfc3339_utc};
use crate::commands::run_directory::claim_named;
use crate::commands::standard_streams::print_diagnostic;

/// A scheduler that ends a program waits this long for it, or longer: half a minute is usual.
const GRACE: Duration = Duration::from_secs(25);

/// The journal, in the folder of what is unfinished.
const JOURNAL: &str = "journal";

/// Which part of what is made, where, and since when.
pub struct ShardPlan {
    /// The verb.
    pub study: Study,
    /// Which part.
    pub shard: Shard,
    /// Its directory, in the folder of all shards.
    pub claimed: ClaimedTarget,
    /// Whether what others have begun there is thrown away.
    pub overwrites: bool,
    /// When it was begun.
    pub started: Timestamp,
}

impl ShardPlan {
    /// Takes the directory of `shard`, in the folder that `output` names.
    pub fn claim(study: Study, shard: Shard, output: &OutputArgs) -> Result<Self, Failure> {
        let of_shard = OutputArgs {
            output: output.output.as_ref().map(|it| it.join(shard.folder_name())),
            overwrite: output.overwrite,
        };
        let finished = of_shard.output.as_deref().filter(|_| !output.overwrite);
        if let Some((folder, record)) = finished.and_then(|it| Some((it, finished_shard(it)?))) {
            return Err(Usage(format!(
                "{} is there: shard {shard} of `{}`, finished, begun at {}; merge it, or make it again with --overwrite",
                folder.display(),
                record.study.name(),
                record.created
            ))
            .into());
        }
        let no_folder = || Usage("--shard needs -o, the folder of all shards".to_owned());
        let claimed = claim_named(&of_shard)?.ok_or_else(no_folder)?;
        Ok(Self { study, shard, claimed, overwrites: output.overwrite, started: Timestamp::now() })
    }

    /// What the manifest says of the shard before it has done anything.
    pub fn record(&self, share: ShareOfWork) -> ShardRecord {
        ShardRecord {
            index: self.shard.index(),
            count: self.shard.count(),
            created: rfc3339_utc(self.started),
            study: self.study,
            program: program_checksum(),
            cut_by: share.cut_by,
            parts: share.parts,
            processors: Vec::new(),
            files: Vec::new(),
            recordings: Vec::new(),
            worst_recorded: Vec::new(),
        }
    }
}

/// What decides the rows of a shard: its `manifest`, without what may differ when it is continued, and `rules` that this lacks.
pub fn identity_of_shard(manifest: &impl Serialize, rules: Value) -> JournalIdentity {
    let mut value = serde_json::to_value(manifest).expect("a manifest has text keys only");
    let identity = value.as_object_mut().expect("a manifest is an object");
    for passing in ["created", "argv", "machine"] {
        identity.remove(passing);
    }
    if let Some(shard) = identity.get_mut("shard").and_then(Value::as_object_mut) {
        shard.remove("created");
    }
    identity.insert("rules".to_owned(), rules);
    std::mem::take(identity)
}

/// A shard that is being made.
pub struct UnfinishedShard {
    /// What it leaves for now.
    pub folder: PathBuf,
    /// What it has done so far.
    pub journal: Journal,
    claimed: ClaimedTarget,
    shard: Shard,
    // How many scans or objects it has, in words.
    extent: String,
}

impl UnfinishedShard {
    /// Opens what there is of the shard of `plan`, or begins it; `extent` says what it has, such as `60 scans`. What was done before
    /// is handed to `on_entry`.
    ///
    /// From now on the program takes its time when it is asked to end.
    pub fn open<Entry: DeserializeOwned>(
        plan: ShardPlan,
        identity: &JournalIdentity,
        extent: String,
        on_entry: impl FnMut(Entry),
    ) -> Result<Self, Failure> {
        let mut folder = plan.claimed.target().as_os_str().to_owned();
        folder.push(".unfinished");
        let folder = PathBuf::from(folder);
        std::fs::create_dir_all(&folder)
            .map_err(|source| ArchiveError::Write { path: folder.clone(), source })?;
        let other = if plan.overwrites { OtherJournal::Discard } else { OtherJournal::Refuse };
        let kind = (JournalKind::Shard, identity);
        let journal = Journal::open(&folder.join(JOURNAL), kind, other, on_entry)?;
        let unfinished = Self { folder, journal, claimed: plan.claimed, shard: plan.shard, extent };
        set_last_words(unfinished.how_to_go_on());
        set_grace(GRACE);
        Ok(unfinished)
    }

    /// Says how much was done before.
    pub fn tell_of_continuing(&self, n_done: usize, of: &str) {
        print_diagnostic(format_args!("Continuing with {n_done} of {of} from {}", self.folder.display()));
    }

    /// `failure`, after it was said how the shard can go on.
    pub fn ended_by(&self, failure: Failure) -> Failure {
        print_diagnostic(self.how_to_go_on());
        failure
    }

    fn how_to_go_on(&self) -> String {
        format!(
            "What is done of the {} of shard {} is kept in {}: to go on with the others, give the same command again",
            self.extent,
            self.shard,
            self.folder.display()
        )
    }

    /// Makes the directory of the shard: `fill` writes its files and returns its manifest. What was kept until then is not needed any
    /// more.
    pub fn finish(
        self,
        fill: impl FnOnce(&Path, &Journal, &RunDirectory) -> Result<String, Failure>,
    ) -> Result<(), Failure> {
        let Self { folder, journal, claimed, shard, extent } = self;
        let directory = RunDirectory::begin(claimed)?;
        let manifest = fill(&folder, &journal, &directory)?;
        directory.write_file(MANIFEST_JSON, manifest.as_bytes())?;
        let finished = directory.finish()?;
        let removed = std::fs::remove_dir_all(&folder);
        removed.map_err(|source| ArchiveError::Write { path: folder, source })?;
        set_last_words(String::new());
        print_diagnostic(format_args!("Shard {shard}: {extent}, {}", finished.display()));
        Ok(())
    }
}
